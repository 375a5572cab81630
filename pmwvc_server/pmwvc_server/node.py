# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server node: the shared object and every user's avatar.

The main thread runs the loop (:mod:`pmwvc_server.loop`); a second one serves parameters,
``~/start`` (Trigger, where ``start.paused`` is set), markers, diagnostics and the log. What is
constant in an environment is published once, on ``~/scene``.
"""

import json
import secrets
import sys
import threading
from collections.abc import Callable, Mapping
from functools import partial

from rclpy.node import Node
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from pmwvc_core.frame import Presence
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.runtime.pacing import hold_memory
from pmwvc_core.runtime.process import OK, WARN, publish_health, run_node
from pmwvc_core.runtime.topics import LATCHED_QOS
from pmwvc_core.runtime.watch import Watch
from pmwvc_core.server.black_box import description_of
from pmwvc_core.transport.receiver import diagnostics
from pmwvc_core.wave.impedance import server_impedance
from pmwvc_core.words import count
from pmwvc_server.loop import ServerLoop
from pmwvc_server.settings import declare_settings
from pmwvc_server.wires import RosWires, markers

MARKER_HZ = 30.0
NEWS = {
    Presence.ABSENT: "left", Presence.JOINING: "joins", Presence.COUPLED: "is coupled",
    Presence.DAMPING: "is silent: its avatar is damped",
}  # fmt: skip


class ServerNode:
    """The node: settings, environment and loop."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self._pending: list[Callable[[], None]] = []
        self.settings = settings = declare_settings(
            node, self._change, self._change_contact, self._settle
        )
        self.names = [user.name for user in settings.users]
        epoch = secrets.randbits(64) or 1
        wires = RosWires(node, settings, epoch=epoch)
        self.loop = ServerLoop(
            settings.make_step(epoch), links=wires.links, publish_trace=wires.publish_trace
        )
        if scene := description_of(self.loop.protocol.s.environment.body):
            self._scene = node.create_publisher(String, "~/scene", LATCHED_QOS)
            self._scene.publish(String(data=json.dumps(scene)))
        self._markers = node.create_publisher(MarkerArray, "markers", 1)
        links = {
            f"{name}/up": (f"~/{name}/wave_up", f"~/{name}/wave_down", inbox)
            for name, inbox in zip(self.names, self.loop.protocol.inboxes, strict=True)
        }
        self._watch = Watch(node, self.loop, links=links, reception="~/reception", epoch=epoch)
        self._contained, self._present = 0, self.loop.protocol.presence
        node.create_timer(1.0 / MARKER_HZ, self._show)
        publish_health(node, self._health)
        self.loop.memory = hold_memory()

    def run(self, stop: threading.Event) -> None:
        """Run the loop."""
        self._watch.begin()
        self.loop.run(stop)

    def close(self) -> None:
        """Log what the last step brought, report what was received."""
        self._log_changes()
        self._watch.publish()

    def _change(self, params: ServerParams) -> None:
        self._pending.append(partial(self.loop.configure, params))

    def _change_contact(self, user: int, params: ContactParams) -> None:
        impedance = server_impedance(params, self.settings.users[user].master)
        self._pending.append(partial(self.loop.protocol.configure_user, user, params, impedance))

    def _settle(self) -> None:
        """Hand over what was set together: one step takes it over."""
        changes, self._pending = self._pending, []

        def together() -> None:
            for change in changes:
                change()

        if changes:
            self.loop.protocol.hand_over(together)

    def _show(self) -> None:
        """Publish the markers and log who came and went."""
        self._log_changes()
        if self._markers.get_subscription_count():
            stamp = self.node.get_clock().now().to_msg()
            size_m = self.settings.server.object_size_m
            self._markers.publish(markers(self.loop, self.names, size_m=size_m, stamp=stamp))

    def _log_changes(self) -> None:
        before, self._present = self._present, self.loop.protocol.presence
        for name, old, new in zip(self.names, before, self._present, strict=True):
            if new is not old:
                self.node.get_logger().info(f"{name} {NEWS[new]}")

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return level, text and values of the diagnostics, once a second."""
        loop = self.loop
        values, missed = self._watch.look()
        values["steps"] = loop.protocol.steps
        silent = []
        for user, name in enumerate(self.names):
            presence = loop.protocol.presence[user]
            silent += [name] if presence is Presence.DAMPING else []
            seen = diagnostics(loop.protocol.inboxes[user], out="down", into="up")
            values[f"{name}: state"] = presence.name.lower()
            values |= {f"{name}: {key}": value for key, value in seen.items()}
        there = sum(presence is not Presence.ABSENT for presence in loop.protocol.presence)
        texts = [f"{there} of {len(self.names)} users"]
        texts += [f"{', '.join(silent)} silent"] if silent else []
        texts += [f"{missed} deadlines missed"] if missed else []
        contained = self._contain(values)
        wrong, peers = self._watch.peers.look()
        values |= peers
        wrong += [contained] if contained else []
        text = "; ".join([*texts, *wrong])
        return (WARN if missed or silent or wrong else OK), text, values

    def _contain(self, values: dict[str, object]) -> str:
        """Return and log what failed in environment or coupling since the last call, if any."""
        faults = self.loop.protocol.faults
        steps, text = faults.steps, faults.text
        values |= {"environment: steps contained": steps, "environment: last fault": text}
        new, self._contained = steps - self._contained, steps
        if new <= 0:  # a coupling that was set in flight counts anew
            return ""
        warning = f"{count(new, 'step')}: {text}"
        if faults.replaced:
            warning = f"the {faults.what} failed in {warning}"
        self.node.get_logger().warning(warning)
        return warning


main = partial(run_node, "server", ServerNode)

if __name__ == "__main__":
    sys.exit(main())
