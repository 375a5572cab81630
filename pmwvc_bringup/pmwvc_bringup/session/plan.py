# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes of a session, from its scenario: module, namespace and parameters of each.

The session runner starts the nodes listed here. Works without ROS.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import yaml

from pmwvc_core.errors import ScenarioError
from pmwvc_core.runtime import parameter_values as shares
from pmwvc_core.runtime.messages import record_of
from pmwvc_core.runtime.parameter_values import given, to_ros_yaml
from pmwvc_core.runtime.token_files import SERVER, TOKEN_FILE
from pmwvc_core.scenario.scenario import Scenario

MODULES = {
    "recorder": "pmwvc_analysis.recorder_node", "netem": "pmwvc_netem.node",
    "server": "pmwvc_server.node", "master": "pmwvc_master.node", "view": "pmwvc_view.node",
}  # fmt: skip


@dataclass(frozen=True)
class NodePlan:
    """One node: its kind, ROS namespace and parameters by dotted name."""

    kind: str
    namespace: str = ""
    parameters: Mapping[str, object] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name for people, logs and events: ``server``, ``user1 master``."""
        return f"{self.namespace} {self.kind}".strip()

    @property
    def ros_name(self) -> str:
        """Full name in the ROS graph."""
        return f"/{self.namespace}/{self.kind}" if self.namespace else f"/{self.kind}"

    @property
    def file_name(self) -> str:
        """Name of its files in a session folder, without a suffix."""
        return self.namespace or self.kind

    def parameter_file(self) -> str:
        """Return the text of its ROS parameter file."""
        return yaml.safe_dump(to_ros_yaml(self.parameters), sort_keys=False, allow_unicode=True)

    def command(self, parameter_file: Path) -> list[str]:
        """Return the command that runs it."""
        words = [sys.executable, "-m", MODULES[self.kind], "--ros-args"]
        if self.namespace:
            words += ["-r", f"__ns:=/{self.namespace}"]
        return [*words, "--params-file", str(parameter_file.resolve())]


@dataclass(frozen=True)
class Page:
    """Address of a session's page: port 0 takes any free one."""

    host: str = "127.0.0.1"
    port: int = 0


def nodes(
    scenario: Scenario, *, folder: Path, tokens: Path | None = None, page: Page | None = None
) -> list[NodePlan]:
    """Return the nodes of a session in the order in which they start.

    ``folder`` is the session folder, ``tokens`` that of the session's tokens, ``page`` where its
    page is served (None: neither is); all but the recorder and the view wait for a call of their
    ``start`` service. ScenarioError where parameters of the scenario change at given times: no
    node does that by itself.
    """
    if scenario.changes:
        text = f"changes = {scenario.changes!r}: must be empty in a live session"
        ways = "set parameters of the running nodes ('ros2 param set'), or use pmwvc simulate"
        raise ScenarioError(scenario.name, [f"{text}; {ways}"])
    names, own = [user.name for user in scenario.users], {"start.paused": True}
    top = own | {name: getattr(scenario, name) for name in shares.TOP_AT_ENDS}
    server: dict[str, object] = {
        **top, "users": names, **given(shares.SHARED_AT_SERVER, scenario),
        **{f"safety.{name}": value for name, value in scenario.times._asdict().items()},
    }  # fmt: skip
    netem: dict[str, object] = {**own, "seed": scenario.seed, "users": names}
    masters = {}
    for user in scenario.users:
        server |= {f"{user.name}.side": user.side, **given(shares.USER_AT_SERVER, user, user.name)}
        netem |= given(shares.USER_AT_NETEM, user, user.name)
        masters[user.name] = {
            **top, "side": user.side,
            **given(shares.USER_AT_MASTER, user), **given(shares.SHARED_AT_MASTER, scenario),
        }  # fmt: skip
    if tokens:
        for name, node in ((SERVER, server), *masters.items()):
            node[TOKEN_FILE] = str(tokens / name)
    recorder = {"folder": str(folder.resolve()), "users": names}
    view = {
        "session.emulated": True, "session.name": scenario.name,
        "session.description": scenario.description, "session.duration_s": scenario.duration_s,
        "session.report": str(folder.resolve() / "report.html"),
    }  # fmt: skip
    return [
        NodePlan("recorder", parameters=recorder),
        NodePlan("netem", parameters=netem),
        NodePlan("server", parameters=server),
        *(NodePlan("master", name, master) for name, master in masters.items()),
        *([NodePlan("view", parameters={**view, **asdict(page)})] if page else []),
    ]


def start_order(planned: Sequence[NodePlan]) -> list[list[str]]:
    """Return groups of ROS names to start in turn: no node sends before its receivers run."""
    kinds = ("netem", "server", "master")
    return [[node.ros_name for node in planned if node.kind == kind] for kind in kinds]


def topics(scenario: Scenario) -> list[str]:
    """Return the topics that need both ends before a session begins: one publisher, and the
    recorder or the receiver of the waves.
    """
    found = ["/server/trace", "/server/reception", "/netem/fates"]
    for user in (user.name for user in scenario.users):
        found += [f"/{user}/trace", f"/{user}/reception"]
        waves = [f"{end}/{user}/wave_{way}" for end in ("", "/server") for way in ("up", "down")]
        found += [*waves, *map(record_of, waves)]
    return found
