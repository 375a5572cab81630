# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A running session found in the ROS graph; the parameters of its nodes, read and set by their ROS
services, and the scenario put together from them.
"""

import asyncio
import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python

from pmwvc_core.errors import ParameterError, PmwvcError, ScenarioError
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


class Parameters:
    """The parameters of other nodes; an executor serves the node in another thread."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._setters: dict[str, Any] = {}

    def read(self, other: str, stop: threading.Event) -> dict[str, Any]:
        """Return all parameters of a node by name; PmwvcError where it does not answer."""
        every = ListParameters.Request(depth=ListParameters.Request.DEPTH_RECURSIVE)
        listed = self._call(ListParameters, f"{other}/list_parameters", every, stop)
        wanted = GetParameters.Request(names=listed.result.names)
        answer = self._call(GetParameters, f"{other}/get_parameters", wanted, stop)
        return dict(zip(wanted.names, map(parameter_value_to_python, answer.values), strict=True))

    async def set(self, other: str, values: Mapping[str, Any]) -> str:
        """Set parameters of a node together; return why it refused, or ""."""
        if other not in self._setters:
            service = f"{other}/set_parameters_atomically"
            self._setters[other] = self._node.create_client(SetParametersAtomically, service)
        client = self._setters[other]
        if not client.service_is_ready():
            return f"{other} is not there"
        wanted = [Parameter(name, value=new).to_parameter_msg() for name, new in values.items()]
        call = client.call_async(SetParametersAtomically.Request(parameters=wanted))
        until_s = time.monotonic() + PATIENCE_S
        while not call.done():
            if time.monotonic() > until_s:
                return f"{other} did not answer within {PATIENCE_S:g} s"
            await asyncio.sleep(ANSWER_S)
        result = call.result().result
        return "" if result.successful else str(result.reason)

    def _call(self, kind: Any, service: str, request: Any, stop: threading.Event) -> Any:
        client = self._node.create_client(kind, service)
        try:
            until_s = time.monotonic() + PATIENCE_S
            call = None
            while not stop.is_set() and time.monotonic() < until_s:
                if call is None and client.service_is_ready():
                    call = client.call_async(request)
                if call is not None and call.done():
                    return call.result()
                time.sleep(ANSWER_S)
            raise PmwvcError(f"no answer to a call of {service}")
        finally:
            self._node.destroy_client(client)


LOOK_S = 0.1
EMULATOR_S = 5.0  # behind all other nodes: until a session counts as one without
TRACE = "/server/trace"
LONGEST_S = 86400.0  # a session that is joined goes on until it ends


@dataclass
class Graph:
    """The nodes of a session and their parameters by node and name, which are kept up to date.

    ``prefix`` is the session's namespace, without a slash at its end; users are in the order of
    the server.
    """

    prefix: str
    users: list[str]
    values: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.server, self.netem = f"{self.prefix}/server", f"{self.prefix}/netem"  # full names

    def master(self, user: str) -> str:
        """Return the full name of a user's master node."""
        return f"{self.prefix}/{user}/master"

    @property
    def emulated(self) -> bool:
        """Tell whether an emulator relays the packets."""
        return bool(self.values.get(self.netem))

    def scenario(self, about: Mapping[str, object]) -> Scenario:
        """Return the scenario that the nodes' parameters make; ``about``: name and length of it.
        PmwvcError where they make none.
        """
        server, netem = self.values[self.server], self.values.get(self.netem, {})
        found: dict[str, Any] = {
            **about,
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


def find(
    node: Node, users: Sequence[str], stop: threading.Event, *, emulated: bool
) -> Graph | None:
    """Wait for a session, and return it; None when asked to stop before.

    Without names of users they are those of its server. An emulator that is not expected is
    looked for only a while. ParameterError where there are several sessions, or other users.
    """
    while not stop.is_set():
        if len(prefixes := _sessions(node)) > 1:
            names = ", ".join(prefix or "/" for prefix in prefixes)
            how = "choose one by its namespace (-r __ns:=/NAME)"
            raise ParameterError(f"several sessions: {names}; {how}")
        if prefixes:
            graph = _read(node, prefixes[0], users, stop, emulated=emulated)
            if graph is not None:
                return graph
        else:
            node.get_logger().info("waiting for a session", once=True)
        time.sleep(LOOK_S)
    return None


def _sessions(node: Node) -> list[str]:
    """Return the namespaces of all sessions at or below the node's own."""
    own = node.get_namespace().rstrip("/")
    found = {
        topic.removesuffix(TRACE)
        for topic, types in node.get_topic_names_and_types()
        if topic.endswith(TRACE)
        and topic.startswith(f"{own}/")
        and "pmwvc_msgs/msg/ServerTrace" in types
        and node.count_publishers(topic)
    }
    return sorted(found)


def _read(
    node: Node, prefix: str, users: Sequence[str], stop: threading.Event, *, emulated: bool
) -> Graph | None:
    """Return a session whose nodes have all answered; None where one is not there yet."""
    graph, parameters = Graph(prefix, []), Parameters(node)
    try:
        graph.values[graph.server] = parameters.read(graph.server, stop)
        graph.users = list(graph.values[graph.server]["users"])
        if users and list(users) != graph.users:
            raise ParameterError(f"users = {list(users)}: the server has {graph.users}")
        for master in map(graph.master, graph.users):
            graph.values[master] = parameters.read(master, stop)
        until_s = time.monotonic() + (math.inf if emulated else EMULATOR_S)
        while not (found := node.count_publishers(f"{graph.netem}/links")):
            if stop.is_set() or time.monotonic() > until_s:
                break
            time.sleep(LOOK_S)
        if found:  # an emulator publishes the states of the links
            graph.values[graph.netem] = parameters.read(graph.netem, stop)
    except ParameterError:
        raise
    except PmwvcError:
        return None
    return graph
