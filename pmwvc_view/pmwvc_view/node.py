# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The view node: a running session in the browser.

Waits for a session (its nodes may have been started by anything), then serves the page until it is
asked to stop or the session is over, and says ``page ADDRESS`` on standard output.
"""

import sys
import threading
from collections.abc import Mapping
from functools import partial
from typing import Any

from rclpy.node import Node

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.runtime.parameters import declare_names, declare_value
from pmwvc_core.runtime.process import OK, publish_health, run_node
from pmwvc_core.runtime.real_time import request_priority
from pmwvc_view import SNAPSHOT_S
from pmwvc_view.live.graph import LONGEST_S, find
from pmwvc_view.live.session import LiveSession
from pmwvc_view.web.access import is_loopback, new_token, why_refused
from pmwvc_view.web.server import PageServer

PRIORITY = 2  # below loops and recorder: a hand waits for no ordinary program
# Default, unit, range and description of each parameter.
SPECS: Mapping[str, tuple[Any, str, float | None, float | None, str]] = {
    "host": (
        "127.0.0.1",
        "-",
        None,
        None,
        "address to listen on; beyond loopback others can join",
    ),
    "port": (0, "", 0, 65535, "port to listen on, 0: any free one"),
    "token": ("", "", None, None, "token of the page's address (empty: a random one)"),
    "snapshot_hz": (1.0 / SNAPSHOT_S, "Hz", 1.0, 125.0, "snapshots per second"),
    "session.name": ("session", "", None, None, "name of the session"),
    "session.description": ("", "", None, None, "what the session shows"),
    "session.report": ("", "", None, None, "file of its report, once it is over"),
    "session.emulated": (False, "", None, None, "an emulator belongs to the session"),
    "session.duration_s": (0.0, "s", 0.0, LONGEST_S, "its length, 0: not known"),
}


class View:
    """The node: settings, and the server of the page."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._users, self._values = declare_settings(node)
        self._server: PageServer | None = None
        publish_health(node, self._health)

    def run(self, stop: threading.Event) -> None:
        """Find the session, and serve its page."""
        request_priority(PRIORITY)
        values = self._values
        graph = find(self._node, self._users, stop, emulated=values["session.emulated"])
        if graph is None:
            return
        length_s, snapshot_s = float(values["session.duration_s"]), 1.0 / values["snapshot_hz"]
        about = {name: values[f"session.{name}"] for name in ("name", "description")}
        session = LiveSession(
            self._node, graph, about={**about, "duration_s": length_s or LONGEST_S},
            snapshot_s=snapshot_s, duration_s=length_s or None, report=values["session.report"],
        )  # fmt: skip
        host, port, token = values["host"], values["port"], values["token"] or new_token()
        self._server = server = PageServer(
            session, host=host, port=port, token=token, snapshot_s=snapshot_s
        )
        if not is_loopback(host):
            text = f"host = {host}: whoever has the address with its token can take part"
            self._node.get_logger().warning(text)
        if why := why_refused(host, port):
            raise ParameterError(f"host = {host}, port = {port}: {why}")
        server.run(stop, lambda: print(f"page {server.address}", flush=True))

    def close(self) -> None:
        """Nothing is left to let go of."""

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return what people should know, once a second."""
        if self._server is None:
            return OK, "waiting for a session", {}
        return OK, "serving", {"pages": self._server.pages, "port": self._server.port}


def declare_settings(node: Node) -> tuple[list[str], dict[str, Any]]:
    """Declare the parameters; return the names of the users and all other values by name."""
    users = declare_names(node, "users", [], "names of the users (empty: those of the session)")
    values = {}
    for name, (default, unit, low, high, text) in SPECS.items():
        spec = Spec(type(default), unit, low=low, high=high, description=text)
        values[name] = declare_value(node, name, spec, default)
    return users, values


main = partial(run_node, "view", View)

if __name__ == "__main__":
    sys.exit(main())
