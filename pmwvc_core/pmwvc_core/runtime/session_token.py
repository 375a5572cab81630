# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameter that names the file of a node's session token."""

from rclpy.node import Node

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.runtime.parameters import declare_value
from pmwvc_core.runtime.token_files import TOKEN_FILE, read_token
from pmwvc_core.transport.token import Token


def declare_token(node: Node, *, user: str) -> Token | None:
    """Declare the parameter; return the token in its file, None for an open session. It has to be
    that of ``user``; of "" the key of the whole session. ParameterError where the file holds no
    token, or another one's.
    """
    spec = Spec(str, description="file with the session token of this node; empty: open session")
    path: str = declare_value(node, TOKEN_FILE, spec, "")
    if not path:
        return None
    try:
        token = read_token(path)
    except ParameterError as error:
        raise ParameterError(f"{TOKEN_FILE} = {error}") from None
    if token.user != user:
        held, wanted = (
            f"the token of {n}" if n else "the key of the session" for n in (token.user, user)
        )
        raise ParameterError(f"{TOKEN_FILE} = {path}: {held}, must be {wanted}")
    return token
