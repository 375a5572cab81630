# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that runs as ROS nodes."""

import asyncio
from collections.abc import Sequence
from typing import Any

from rclpy.node import Node

from pmwvc_core.errors import PmwvcError
from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view import description
from pmwvc_view.controls import Control, Setting
from pmwvc_view.live.graph import AboutSession, Graph
from pmwvc_view.live.topics import Inlets, PublishedHand, TraceReader, scene_of
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Session, ramped

STEP_S = 0.02  # between two steps of a delay on its way
SILENT_S = 10.0  # without a trace: the session is over; a busy machine may stall for seconds


class LiveSession(Session):
    """See :class:`pmwvc_view.session.Session`; an executor serves the node in another thread."""

    can = Session.can - {"pause", "restart"}

    def __init__(self, node: Node, graph: Graph, about: AboutSession) -> None:
        super().__init__(live=True)
        self._node, self._graph, self._about = node, graph, about
        self._duration_s, self.report = about.duration_s or None, about.report
        preset = graph.values.get(graph.netem, {}).get("preset", "none")
        self.preset = None if preset == "none" else str(preset)
        scenario = graph.scenario(about)
        exact = [user.name for user in scenario.users if user.device.is_simulated]
        self._show(scenario, exact, scene_of(node, f"{graph.server}/scene"))
        self._inlets = Inlets(node, graph, TraceReader(self._feed.tape, dof=scenario.dof))
        self._hands = {
            user.name: PublishedHand(node, f"{graph.prefix}/{user.name}", scenario.server.lever_m)
            for user in scenario.users
            if user.operator.is_remote
        }
        self.remote = list(self._hands)

    def poll(self) -> Sequence[Snapshot]:
        """Return the snapshots since the last call."""
        inlets = self._inlets
        inlets.empty(self._feed)
        if inlets.changed:
            inlets.changed = False
            try:
                self._scenario = self.wanted = self._graph.scenario(self._about)
                self._lags = description.lags(self._scenario, live=True)
            except PmwvcError as error:  # parameters that make no scenario leave it as it was
                self._node.get_logger().warning(str(error))
        if self._feed.tape.zero_ns is not None and inlets.silent_s > SILENT_S:
            self.ended = f"no trace has come for {SILENT_S:g} s: the session is over"
        return self._snapshots(inlets.now_ns(), inlets.round_trips)

    def _notes(self) -> list[str]:
        return [] if self._graph.emulated else ["The links are not emulated here."]

    def _give(self, user: str, position: Sequence[float] | None) -> None:
        self._hands[user].give(position)

    async def _change(self, control: Control, wanted: Scenario, value: Setting) -> str:
        """Change parameters of the nodes, a delay a little at a time."""
        if control.path.startswith("link.") and not self._graph.emulated:
            return "the links are not emulated in this session"
        present = self._scenario
        while present != wanted:
            step = ramped(present, wanted, over_s=STEP_S)
            before, after = self._values_of(present), self._values_of(step)
            changes = {
                node: {name: new for name, new in each.items() if new != before[node][name]}
                for node, each in after.items()
            }
            calls = [self._graph.set(node, each) for node, each in changes.items() if each]
            if why := "; ".join(filter(None, await asyncio.gather(*calls))):
                return why
            present = step
            if present != wanted:
                await asyncio.sleep(STEP_S)
        self._name_network(control, value)
        return ""

    def _values_of(self, scenario: Scenario) -> dict[str, dict[str, Any]]:
        """Return the parameters that may change, by node and name."""
        found = {self._graph.server: values_of("server", scenario.server), self._graph.netem: {}}
        for user in scenario.users:
            found[self._graph.server] |= values_of(f"{user.name}.server", user.contact)
            for way, link in (("up", user.link_up), ("down", user.link_down)):
                found[self._graph.netem] |= values_of(f"{user.name}.link.{way}", link)
            found[self._graph.master(user.name)] = values_of("master", user.master)
        return found

    def close(self) -> None:
        """Open all hands, end the predictor."""
        for hand in self._hands.values():
            hand.give(None)
        super().close()
