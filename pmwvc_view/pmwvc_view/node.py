# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The view node: a running session in the browser.

Waits for a session (its nodes may have been started by anything), then serves the page until it is
asked to stop or the session is over, and says ``page ADDRESS`` on standard output.
"""

import sys
import threading
from dataclasses import dataclass
from functools import partial

from rclpy.node import Node

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Validated
from pmwvc_core.params.fields import group, parameter
from pmwvc_core.runtime.pacing import request_priority
from pmwvc_core.runtime.parameters import declare
from pmwvc_core.runtime.process import run_node
from pmwvc_view.live.graph import AboutSession, find
from pmwvc_view.live.session import LiveSession
from pmwvc_view.web.access import is_loopback, new_token, why_refused
from pmwvc_view.web.server import PageServer

PRIORITY = 2  # below loops and recorder: a hand waits for no ordinary program


@dataclass(frozen=True)
class ViewParams(Validated):
    """The parameters of the node."""

    host: str = parameter(
        "127.0.0.1", "-", "address to listen on; beyond loopback others can join"
    )
    port: int = parameter(0, "0..65535", "port to listen on, 0: any free one")
    session: AboutSession = group(AboutSession)


class View:
    """The node: settings, and the server of the page."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._params = declare(node, "", ViewParams)

    def run(self, stop: threading.Event) -> None:
        """Find the session, and serve its page."""
        request_priority(PRIORITY)
        params = self._params
        graph = find(self._node, stop, emulated=params.session.emulated)
        if graph is None:
            return
        session = LiveSession(self._node, graph, params.session)
        host, port = params.host, params.port
        server = PageServer(session, host=host, port=port, token=new_token())
        if not is_loopback(host):
            text = f"host = {host}: whoever has the address with its token can take part"
            self._node.get_logger().warning(text)
        if why := why_refused(host, port):
            raise ParameterError(f"host = {host}, port = {port}: {why}")
        server.run(stop, lambda: print(f"page {server.address}", flush=True))

    def close(self) -> None:
        """Nothing is left to let go of."""


main = partial(run_node, "view", View)

if __name__ == "__main__":
    sys.exit(main())
