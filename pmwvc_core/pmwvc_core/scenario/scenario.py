# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario: everything that defines a session, as nested frozen dataclasses.

Reading one from a mapping (a YAML file, ``--set`` options): :mod:`pmwvc_core.scenario.reader`.
Its parameters by dotted name: :mod:`pmwvc_core.scenario.names`.

Equations: docs/theory.md 1.8.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pmwvc_core.controllers.library import (
    CHANNELS,
    RECORDS,
    STRICT,
    is_strict,
    is_zeroing,
    record_of,
)
from pmwvc_core.errors import ScenarioError
from pmwvc_core.params import (
    BaselineParams,
    ContactParams,
    DeviceParams,
    LinkParams,
    MasterParams,
    OperatorParams,
    SafetyParams,
    ServerParams,
    Spec,
    TaskParams,
)
from pmwvc_core.params.names import flattened, nested
from pmwvc_core.scenario.conflicts import conflicts
from pmwvc_core.server.couplings import COUPLINGS, Coupling
from pmwvc_core.server.environments import Environment, environment_of
from pmwvc_core.wave.impedance import Impedance, impedance_of, server_impedance

TOP: Mapping[str, Spec] = {
    "name": Spec(str, description="name of the scenario; also part of the session folder's name"),
    "description": Spec(str, description="one sentence: what happens, what one should see"),
    "duration_s": Spec(float, "s", above=0.0, high=86400.0, description="length of the session"),
    "seed": Spec(int, "-", low=0, high=2**31 - 1, description="seed of all random numbers"),
    "controller": Spec(
        str,
        choices=tuple(RECORDS.library),
        plugins=RECORDS.installed,
        description="controller between the users and the server",
    ),
    "channel": Spec(
        str,
        choices=CHANNELS,
        description="way of the waves between the ends; strict: integral and energy in every "
        "packet, never more energy out than in; plain: samples of the wave, as in the "
        "dissertation, each held until the next comes; zeroing: each for one step, then zero",
    ),
    "disturbances": Spec(
        str,
        description="live: nodes killed, started, stopped and continued, TIME ACTION NODE; ...: "
        "6 kill server; 7 start server (also netem, recorder, user1)",
    ),
    "dof": Spec(int, "-", low=1, high=6, description="axes of motion"),
    "users": Spec(int, "-", low=1, high=8, description="number of users"),
    "changes": Spec(
        str,
        description="parameters that change during a session in virtual time, times in s: "
        "'TIME NAME=VALUE ...; TIME NAME=VALUE ...'",
    ),
}
REQUIRED = ("name", "duration_s", "controller", "users")
DEFAULTS: Mapping[str, Any] = {
    "description": "",
    "seed": 1,
    "channel": STRICT,
    "disturbances": "",
    "dof": 1,
    "changes": "",
}

# Dotted prefix -> (attribute, dataclass): what each user has for itself, and what all share.
USER_GROUPS: Mapping[str, tuple[str, type]] = {
    "master": ("master", MasterParams),
    "baseline": ("baseline", BaselineParams),
    "device": ("device", DeviceParams),
    "operator": ("operator", OperatorParams),
    "safety": ("safety", SafetyParams),
    "server": ("contact", ContactParams),
    "link.up": ("link_up", LinkParams),
    "link.down": ("link_down", LinkParams),
}
SHARED_GROUPS: Mapping[str, tuple[str, type]] = {
    "server": ("server", ServerParams),
    "task": ("task", TaskParams),
}
SIDE = Spec(
    int, "-", low=-1, high=1, description="side of the object the user is on: -1 pushes towards +x"
)


@dataclass(frozen=True)
class User:
    """One user: device, hand, limits, wave port, contact at the server, and the link both ways."""

    name: str
    side: int
    master: MasterParams
    baseline: BaselineParams
    device: DeviceParams
    operator: OperatorParams
    safety: SafetyParams
    contact: ContactParams
    link_up: LinkParams
    link_down: LinkParams

    @property
    def impedance(self) -> Impedance:
        """Wave impedance of this user's master [N s/m]."""
        return impedance_of(self.master)

    @property
    def server_impedance(self) -> Impedance:
        """Wave impedance of this user's port at the server [N s/m]."""
        return server_impedance(self.contact, self.master)


@dataclass(frozen=True)
class Scenario:
    """A complete session: users, server, task, controller, duration and seed.

    Raises
    ------
    ScenarioError
        If groups that are each right contradict one another.
    """

    name: str
    description: str
    duration_s: float
    seed: int
    controller: str
    dof: int
    users: tuple[User, ...]
    server: ServerParams
    task: TaskParams
    channel: str = STRICT
    changes: str = ""
    disturbances: str = ""

    def __post_init__(self) -> None:
        """Check what holds between groups."""
        problems = conflicts(self)
        if problems:
            raise ScenarioError(self.name, problems)

    @property
    def strict(self) -> bool:
        """Whether the waves of this session run on the strict channel."""
        return is_strict(self.controller, self.channel)

    @property
    def zeroing(self) -> bool:
        """Whether a wave of this session counts for one step, with zero where none has come."""
        return is_zeroing(self.controller, self.channel)

    @property
    def coupling(self) -> Coupling:
        """The method by which the server closes its algebraic loop."""
        return record_of(self.controller).coupling or COUPLINGS.of(self.server.coupling)

    @property
    def environment(self) -> Environment:
        """The environment that the avatars touch."""
        return environment_of(self.server.environment)

    @property
    def tick_s(self) -> float:
        """Period of every force loop [s]."""
        return self.users[0].master.tick_s

    @property
    def period_ticks(self) -> int:
        """Force-loop ticks per server step."""
        return round(self.server.period_s / self.tick_s)

    def flat(self) -> dict[str, Any]:
        """Return every parameter by its dotted name.

        A per-user parameter that is the same for all stands once, without the user's name;
        otherwise one entry a user.
        """
        values: dict[str, Any] = {
            "name": self.name,
            "description": self.description,
            "duration_s": self.duration_s,
            "seed": self.seed,
            "controller": self.controller,
            "channel": self.channel,
            "disturbances": self.disturbances,
            "dof": self.dof,
            "users": len(self.users),
            "changes": self.changes,
        }
        for prefix, (attribute, _) in SHARED_GROUPS.items():
            values |= flattened(prefix, getattr(self, attribute))
        each = [
            {
                name: value
                for prefix, (attribute, _) in USER_GROUPS.items()
                for name, value in flattened(prefix, getattr(user, attribute)).items()
            }
            for user in self.users
        ]
        for name in each[0]:
            if all(user[name] == each[0][name] for user in each):
                values[name] = each[0][name]
            else:
                values |= {
                    f"{u.name}.{name}": v[name] for u, v in zip(self.users, each, strict=True)
                }
        sides = {f"{user.name}.side": user.side for user in self.users}
        return values | sides

    def to_dict(self) -> dict[str, Any]:
        """Return the complete scenario as nested plain dictionaries, the form of a YAML file."""
        return nested(self.flat())
