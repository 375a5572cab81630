# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Session tokens in files, each as secret as a password.

A folder holds the key of a session in ``server`` and the token of each user in a file with the
user's name. Needs no ROS.
"""

import json
import os
import secrets
from collections.abc import Sequence
from pathlib import Path

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.transport.packet import KEY_BYTES, Token

TOKEN_FILE = "session.token_file"  # the parameter of server and master
TOKEN_SPEC = Spec(str, description="file with the session token of this node; empty: open session")
SERVER = "server"


def write_token(path: Path, token: Token) -> None:
    """Write a token into a new file for its owner only; ParameterError where it cannot be made."""
    found = {"session": f"{token.session:016x}", "user": token.user, "key": token.key.hex()}
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            json.dump(found, file)
    except OSError as error:
        raise ParameterError(f"{path}: {error.strerror or error}") from None


def write_session(folder: Path, users: Sequence[str]) -> list[Path]:
    """Write a session's key and a token per user; return the files; else ParameterError."""
    wrong = [name for name in users if not name.isidentifier() or name == SERVER]
    if wrong or len(set(users)) != len(users):
        raise ParameterError(
            f"users = {', '.join(users)}: must be different names of letters, digits and '_', "
            f"and not {SERVER}"
        )
    key = Token.of_session(secrets.token_bytes(KEY_BYTES))
    tokens = {folder / SERVER: key, **{folder / user: key.of(user) for user in users}}
    if there := [str(path) for path in tokens if path.exists()]:
        raise ParameterError(f"{', '.join(there)}: there already; a session has a key of its own")
    for path, token in tokens.items():
        write_token(path, token)
    return list(tokens)


def read_token(path: str | Path) -> Token:
    """Return the token in a file; ParameterError in one line where there is none."""
    try:
        found = json.loads(Path(path).expanduser().read_text(encoding="ascii"))
        token = Token(int(found["session"], 16), str(found["user"]), bytes.fromhex(found["key"]))
        if len(token.key) != KEY_BYTES or not 0 < token.session < 1 << 64:
            raise ValueError
        return token
    except OSError as error:
        raise ParameterError(f"{path}: {error.strerror}; a session token is needed") from None
    except (KeyError, TypeError, ValueError):
        raise ParameterError(f"{path}: holds no session token; 'pmwvc token' makes one") from None


def token_of_node(path: str, *, user: str) -> Token | None:
    """Return a node's token, None without a file; ParameterError if it is another's."""
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
