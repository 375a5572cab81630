# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A running session found in the ROS graph; the parameters of its nodes, read and set by their ROS
services, and the scenario put together from them.
"""

import asyncio
import math
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python

from pmwvc_core.errors import PmwvcError, ScenarioError
from pmwvc_core.params import Validated
from pmwvc_core.params.fields import parameter
from pmwvc_core.runtime.parameter_values import (
    SHARED_AT_SERVER,
    TOP_AT_ENDS,
    USER_AT_MASTER,
    USER_AT_NETEM,
    USER_AT_SERVER,
    taken_back,
)
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.controls import renamed

PATIENCE_S = 5.0
ANSWER_S = 0.005
LOOK_S = 0.1
EMULATOR_S = 5.0  # behind all other nodes: until a session counts as one without
TRACE = "/server/trace"
LONGEST_S = 86400.0  # a session that is joined goes on until it ends


@dataclass(frozen=True)
class AboutSession(Validated):
    """What nobody can see of a session in the graph: parameters of the view node."""

    name: str = parameter("session", "-", "name of the session")
    description: str = parameter("", "-", "what the session shows")
    report: str = parameter("", "-", "file of its report, once it is over")
    emulated: bool = parameter(False, "-", "an emulator belongs to the session")
    duration_s: float = parameter(0.0, f"0..{LONGEST_S:g} s", "its length, 0: not known")


class Graph:
    """The nodes of a session and their parameters by node and name, kept up to date, read and set
    until asked to stop, while another thread serves the node; ``prefix`` is its namespace, without
    a slash at its end.
    """

    def __init__(self, node: Node, stop: threading.Event, prefix: str) -> None:
        self._node, self._stop, self.prefix = node, stop, prefix
        self._clients: dict[str, Any] = {}
        self.server, self.netem = f"{prefix}/server", f"{prefix}/netem"  # full names
        self.users: list[str] = []  # in the order of the server
        self.values: dict[str, dict[str, Any]] = {}

    def read(self, other: str) -> dict[str, Any]:
        """Return all parameters of a node by name; PmwvcError where it does not answer."""
        every = ListParameters.Request(depth=ListParameters.Request.DEPTH_RECURSIVE)
        listed = self._call(ListParameters, f"{other}/list_parameters", every)
        wanted = GetParameters.Request(names=listed.result.names)
        answer = self._call(GetParameters, f"{other}/get_parameters", wanted)
        return dict(zip(wanted.names, map(parameter_value_to_python, answer.values), strict=True))

    async def set(self, other: str, values: Mapping[str, Any]) -> str:
        """Set parameters of a node together; return why it refused, or ""."""
        wanted = [Parameter(name, value=new).to_parameter_msg() for name, new in values.items()]
        request = SetParametersAtomically.Request(parameters=wanted)
        service = f"{other}/set_parameters_atomically"
        try:
            answer = await asyncio.to_thread(self._call, SetParametersAtomically, service, request)
        except PmwvcError as error:
            return str(error)
        return "" if answer.result.successful else str(answer.result.reason)

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        if service not in self._clients:
            self._clients[service] = self._node.create_client(kind, service)
        client, call = self._clients[service], None
        until_s = time.monotonic() + PATIENCE_S
        while not self._stop.is_set() and time.monotonic() < until_s:
            if call is None and client.service_is_ready():
                call = client.call_async(request)
            if call is not None and call.done():
                return call.result()
            time.sleep(ANSWER_S)
        raise PmwvcError(f"{service} did not answer within {PATIENCE_S:g} s")

    def master(self, user: str) -> str:
        """Return the full name of a user's master node."""
        return f"{self.prefix}/{user}/master"

    @property
    def emulated(self) -> bool:
        """Tell whether an emulator relays the packets."""
        return bool(self.values.get(self.netem))

    def scenario(self, about: AboutSession) -> Scenario:
        """Return the scenario that the nodes' parameters make; PmwvcError where they make none."""
        server, netem = self.values[self.server], self.values.get(self.netem, {})
        found: dict[str, Any] = {
            "name": about.name,
            "description": about.description,
            "duration_s": about.duration_s or LONGEST_S,
            **{name: server[name] for name in TOP_AT_ENDS},
            "users": len(self.users),
            "seed": netem.get("seed", 1),
            **taken_back(SHARED_AT_SERVER, server),
        }
        for number, user in enumerate(self.users, start=1):
            own = {
                "side": server[f"{user}.side"],
                **taken_back(USER_AT_MASTER, self.values.get(self.master(user), {})),
                **taken_back(USER_AT_SERVER, server, user),  # contacts: their changes are here
                **taken_back(USER_AT_NETEM, netem, user),
            }
            found |= {f"user{number}.{name}": value for name, value in own.items()}
        try:
            scenario = parse_scenario(found, source="the session's parameters")
        except ScenarioError as error:
            raise PmwvcError(str(error)) from None
        return renamed(scenario, self.users)


def find(node: Node, stop: threading.Event, *, emulated: bool) -> Graph | None:
    """Wait for a session in the node's namespace, and return it; None when asked to stop before.
    An emulator that is not expected is looked for only a while.
    """
    prefix = node.get_namespace().rstrip("/")
    while not stop.is_set():
        if node.count_publishers(f"{prefix}{TRACE}"):
            if (graph := _read(node, prefix, stop, emulated=emulated)) is not None:
                return graph
        else:
            node.get_logger().info("waiting for a session", once=True)
        time.sleep(LOOK_S)
    return None


def _read(node: Node, prefix: str, stop: threading.Event, *, emulated: bool) -> Graph | None:
    """Return a session whose nodes have all answered; None where one is not there yet."""
    graph = Graph(node, stop, prefix)
    try:
        graph.values[graph.server] = graph.read(graph.server)
        graph.users = list(graph.values[graph.server]["users"])
        for master in map(graph.master, graph.users):
            graph.values[master] = graph.read(master)
        until_s = time.monotonic() + (math.inf if emulated else EMULATOR_S)
        while not (found := node.count_publishers(f"{graph.netem}/fates")):
            if stop.is_set() or time.monotonic() > until_s:
                break
            time.sleep(LOOK_S)
        if found:  # an emulator publishes the fates of packets
            graph.values[graph.netem] = graph.read(graph.netem)
    except PmwvcError:
        return None
    return graph
