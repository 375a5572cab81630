# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario: everything that defines a session, as nested frozen dataclasses. Equations:
docs/theory.md 1.8.
"""

import contextlib
import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, NamedTuple

from pmwvc_core import params
from pmwvc_core.controllers import library
from pmwvc_core.errors import PmwvcError, ScenarioError
from pmwvc_core.params import Spec, specs
from pmwvc_core.params.behind import behind
from pmwvc_core.params.fields import group, groups, parameter
from pmwvc_core.params.names import joined, leaves, nested
from pmwvc_core.params.user import ServerTimes, server_times
from pmwvc_core.plugins import installed
from pmwvc_core.scenario.conflicts import conflicts
from pmwvc_core.server.couplings import COUPLINGS, Coupling
from pmwvc_core.server.environments import PLUGINS, Environment, environment_of
from pmwvc_core.wave.impedance import Impedance, impedance_of, server_impedance


def _gathered(name: str, plugins: Iterable[str], load: Callable[[str], Any]) -> type:
    """Return the parameters that installed plug-ins declare: one group each, by its name. A
    controller's record names a dataclass ``params`` (values per user: ``user2.lab.gain``); so does
    an environment's factory, whose values are the session's.
    """
    fields = []
    for one in plugins:
        with contextlib.suppress(PmwvcError):  # whoever asks for that plug-in is told why
            kind = getattr(load(one), "params", None)
            if kind is not None:
                fields.append((one, kind, group(kind)))
    here = {"__module__": __name__}  # where another process finds it
    return dataclasses.make_dataclass(name, fields, frozen=True, namespace=here)


ControllerOwn = _gathered("ControllerOwn", library.RECORDS.installed(), library.RECORDS.of)
EnvironmentOwn = _gathered("EnvironmentOwn", installed(PLUGINS.group), PLUGINS.load)


@dataclass(frozen=True)
class User:
    """One user: device, hand, limits, wave port, contact at the server, and the link both ways."""

    name: str
    side: int = parameter(-1, (-1, 1), "side of the object the user is on: -1 pushes towards +x")
    master: params.MasterParams = group(params.MasterParams)
    baseline: params.BaselineParams = group(params.BaselineParams)
    given_device: params.DeviceParams = group(params.DeviceParams)  # these three at the handle
    given_operator: params.OperatorParams = group(params.OperatorParams)
    given_safety: params.SafetyParams = group(params.SafetyParams)
    contact: params.ContactParams = group(params.ContactParams)
    link_up: params.LinkParams = group(params.LinkParams)
    link_down: params.LinkParams = group(params.LinkParams)
    own: Any = group(ControllerOwn)  # of controllers from other packages, by their names

    # As the avatar meets them, behind the device's scale.
    device = behind("given_device")
    operator = behind("given_operator")
    safety = behind("given_safety")

    @property
    def impedance(self) -> Impedance:
        """Wave impedance of this user's master [N s/m]."""
        return impedance_of(self.master)

    @property
    def server_impedance(self) -> Impedance:
        """Wave impedance of this user's port at the server [N s/m]."""
        return server_impedance(self.contact, self.master)

    @property
    def in_contact(self) -> "User":
        """Itself, with the impedance of contact for all motion."""
        rises, own = self.master.rises, self.contact.impedance
        if rises == 1.0:
            return self
        b = self.master.contact_impedance or self.master.impedance
        master = replace(self.master, impedance=b, contact_impedance=None)
        contact = self.contact if own is None else replace(self.contact, impedance=rises * own)
        return replace(self, master=master, contact=contact)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A complete session; ScenarioError where groups contradict one another."""

    name: str = parameter("session", "-", "name, also in that of the session folder")
    description: str = parameter("", "-", "one sentence: events and expected result")
    duration_s: float = parameter(20.0, "> 0 and <= 86400 s", "length")
    seed: int = parameter(1, "0..2147483647", "seed of all random numbers")
    controller: str = parameter(
        "pmwvc", tuple(library.RECORDS.library), "controller between the users and the server",
        group=library.RECORDS.plugins.group,
    )  # fmt: skip
    channel: str = parameter(
        library.STRICT, library.CHANNELS,
        "content of packets; strict: integral and energy of the wave; plain: samples, each held "
        "until the next comes (dissertation); zeroing: samples, each for one step, then zero",
    )  # fmt: skip
    disturbances: str = parameter(
        "", "-", "live, TIME kill|start|stop|continue NODE; ...: 6 kill server; 7 start user1"
    )
    dof: int = parameter(1, "1..6", "axes of motion")
    changes: str = parameter(
        "", "-", "in virtual time [s]: TIME NAME=VALUE ...; TIME NAME=VALUE ..."
    )
    users: tuple[User, ...] = parameter(2, "1..8", "number of users")
    server: params.ServerParams = group(params.ServerParams)
    task: params.TaskParams = group(params.TaskParams)
    own: Any = group(EnvironmentOwn)  # of environments from other packages, by their names

    def __post_init__(self) -> None:
        problems = conflicts(self)
        if problems:
            raise ScenarioError(self.name, problems)

    @property
    def strict(self) -> bool:
        """Whether the waves of this session run on the strict channel."""
        return library.is_strict(self.controller, self.channel)

    @property
    def zeroing(self) -> bool:
        """Whether a wave of this session counts for one step, with zero where none has come."""
        return library.is_zeroing(self.controller, self.channel)

    @property
    def times(self) -> ServerTimes:
        """Times of the server, one for all users."""
        return server_times(user.safety for user in self.users)

    @property
    def coupling(self) -> Coupling:
        """The method by which the server closes its algebraic loop."""
        return library.record_of(self.controller).coupling or COUPLINGS.of(self.server.coupling)

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
        """Return every parameter by its dotted name: once where it is the same for all users, else
        (and always the side) one entry a user.
        """
        values: dict[str, Any] = {}
        for name in sorted(PARAMETERS, key=lambda name: name == "side"):  # which comes last
            each = PARAMETERS[name]
            owners: tuple[User | Scenario, ...] = self.users if each.of_user else (self,)
            found = [attrgetter(each.path)(owner) for owner in owners]
            if name != "side" and all(value == found[0] for value in found):
                values[name] = found[0]
            else:
                names = (f"{user.name}.{name}" for user in self.users)
                values |= dict(zip(names, found, strict=True))
        return values | {"users": len(self.users)}

    def to_dict(self) -> dict[str, Any]:
        """Return the complete scenario as nested plain dictionaries, the form of a YAML file."""
        return nested(self.flat())


class Declaration(NamedTuple):
    """A parameter of a scenario: its path of attributes from a user or from the scenario on."""

    spec: Spec
    path: str
    of_user: bool


_PREFIXES = {"own": "", "contact": "server", "link_up": "link.up", "link_down": "link.down"}


def prefixed(owner: type) -> dict[str, tuple[str, type]]:
    """Return the groups of a user or a scenario by dotted prefix: attribute and dataclass."""
    return {_PREFIXES.get(n, n.removeprefix("given_")): (n, k) for n, k in groups(owner).items()}


def _declared(owner: type, *, of_user: bool) -> dict[str, Declaration]:
    found = {name: Declaration(spec, name, of_user) for name, spec in specs(owner).items()}
    for prefix, (attribute, kind) in prefixed(owner).items():
        for path, spec in leaves("", kind).items():
            found[joined(prefix, path)] = Declaration(spec, f"{attribute}.{path}", of_user)
    return found


# Every parameter by dotted name, without the user's: first what all share.
PARAMETERS: Mapping[str, Declaration] = {
    **_declared(Scenario, of_user=False), **_declared(User, of_user=True),
}  # fmt: skip
