# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The dotted names of a scenario's parameters, and changes by name; within one dataclass see
:mod:`pmwvc_core.params.names`.

``server.contact_stiffness`` means every user, ``user2.device.mass`` that one, ``link.delay_s`` and
``link.*.delay_s`` both directions. ``changes`` of a scenario::

    changes: "2.0 server.contact_stiffness=3000; 4.0 user1.master.impedance=40 link.delay_s=0.02"

A time [s] from the start of the session, then what is set together. A server takes a change over
with its next step, a master with its next frame, a link with its next packet. What may change is
what may change in a running node. Rates change on the strict channel only, whose packets carry the
time that they stand for, and not where avatars move by the velocity of the step before.
"""

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.params import LinkParams, ServerParams, Spec, specs
from pmwvc_core.params.names import hint, replaced, timed
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario, User
from pmwvc_core.server.couplings import Coupling
from pmwvc_core.wave.impedance import MatrixImpedance

USER_NAME = re.compile(r"user([1-9][0-9]*)\.(.+)")


def split_user(name: str) -> tuple[int, str]:
    """Return the number of the user that a name begins with (0: none), and the rest."""
    match = USER_NAME.fullmatch(name)
    return (int(match[1]), match[2]) if match else (0, name)


def _unknown(number: int, rest: str) -> str:
    """Return why a name is refused, with the nearest one."""
    if number and rest in PARAMETERS:
        return f"{rest} is shared by all users; set it without user{number}"
    if rest == "side":
        return "each user has its own; set user1.side"
    of_user = [path for path, each in PARAMETERS.items() if each.of_user]
    known = of_user if number else sorted(PARAMETERS, key=lambda path: path not in of_user)
    links = (f"link.{field}" for field in (*specs(LinkParams), "preset"))
    near = hint(rest, [*known, *links, "master.preset"])
    near = near.replace(" mean ", f" mean user{number}.") if number else near
    group = any(path.startswith(f"{rest}.") for path in PARAMETERS)
    return f"{'a group has no value of its own' if group else 'there is no such parameter'}{near}"


def resolved(name: str) -> tuple[int, list[str]]:
    """Return the user (0: all) and the complete names that a name means; else ScenarioError."""
    number, rest = split_user(name)
    short = rest.removeprefix("link.").removeprefix("*.")
    if rest.startswith("link.") and short in specs(LinkParams):
        return number, [f"link.up.{short}", f"link.down.{short}"]
    if rest not in PARAMETERS or (number and not PARAMETERS[rest].of_user) or name == "side":
        raise ScenarioError(name, [_unknown(number, rest)])
    return number, [rest]


def spec_of(name: str) -> Spec:
    """Return the declaration of a parameter; ScenarioError where there is no such parameter."""
    return PARAMETERS[resolved(name)[1][0]].spec


def varied(scenario: Scenario, name: str, value: object) -> Scenario:
    """Return the scenario with a value, or a column ``(runs, 1)``; else ScenarioError."""
    number, leaves = resolved(name)
    for leaf in leaves:
        _, path, of_user = PARAMETERS[leaf]
        if "." not in path:
            text = f"{leaf}: decides what a scenario is; make two scenarios"
            raise ScenarioError(scenario.name, [text])
        if number > len(scenario.users):
            raise ScenarioError(scenario.name, [f"{leaf}: there is no user{number}"])
        try:
            if of_user:
                users = tuple(
                    replaced(user, path, value) if number in (0, index) else user
                    for index, user in enumerate(scenario.users, start=1)
                )
                scenario = dataclasses.replace(scenario, users=users)
            else:
                scenario = replaced(scenario, path, value)
        except ScenarioError:
            raise
        except ParameterError as error:
            raise ScenarioError(scenario.name, [f"{leaf.rpartition('.')[0]}.{error}"]) from None
    return scenario


CHANGEABLE = ("server", "master", "safety", "link")  # groups
RATE_DROP, PERIOD = "master.rate_drop", "server.period_s"
NEEDS_STRICT = (
    "can change on the strict channel only; on the other channels a packet stands for a fixed time"
)
FIXED = "a black box and its port are fixed once running"
_FORM = "'TIME NAME=VALUE ...; TIME NAME=VALUE ...', such as '2.5 server.object_mass=1'"
_SETTING = re.compile(r"([A-Za-z0-9_.*]+)=(\S+)")


@dataclass(frozen=True)
class Change:
    """Parameters set together: when [s], and values by dotted name."""

    time_s: float
    values: Mapping[str, Any]

    def words(self) -> str:
        """Return what is set, as a scenario has it."""
        return " ".join(f"{name}={value}" for name, value in self.values.items())


def read_changes(text: str) -> list[Change]:
    """Return the changes that a text names, by time; else ParameterError."""
    found = []
    for where, time_s, words in timed("changes", text, _FORM, ordered=False):
        settings = [_SETTING.fullmatch(word) for word in words]
        if None in settings:
            raise ParameterError(f"{where}: must be {_FORM}")
        found.append(Change(time_s, {m[1]: spec_of(m[1]).converted(m[2]) for m in settings if m}))
    return sorted(found, key=lambda change: change.time_s)


def changes_text(changes: list[Change]) -> str:
    """Return changes as ``changes`` of a scenario has them."""
    return "; ".join(f"{change.time_s:.9f} {change.words()}" for change in changes)


def over_time(scenario: Scenario) -> list[tuple[Change, Scenario]]:
    """Return each change with the scenario from then on; ScenarioError where not allowed."""
    found, present = [], replace(scenario, changes="")
    for change in read_changes(scenario.changes):
        present = changed(present, change)
        found.append((change, present))
    return found


def changed(scenario: Scenario, change: Change) -> Scenario:
    """Return a scenario with a change, the rest the same objects; else ScenarioError."""
    result = scenario
    strict, server, coupling = scenario.strict, scenario.server, scenario.coupling
    for name, value in change.values.items():
        leaf = resolved(name)[1][0]
        if leaf.split(".")[0] not in CHANGEABLE or spec_of(name).read_only:
            fixed = "is fixed once a session runs"
        elif leaf.startswith("server.") and coupling.black_box:
            fixed = FIXED
        else:
            fixed = why_fixed(leaf, strict=strict, server=server, coupling=coupling)
        if fixed:
            raise ScenarioError("changes", [f"{name}: {fixed}"])
        result = varied(result, name, value)
    if "server.coupling" in change.values and result.coupling.black_box:
        raise ScenarioError("changes", [f"server.coupling = {result.server.coupling}: {FIXED}"])
    users = [_pinned(*pair) for pair in zip(scenario.users, result.users, strict=True)]
    return replace(result, users=tuple(users))


def _pinned(old: User, new: User) -> User:
    """Return a user whose server port keeps its impedance when only the master's changes."""
    own = new.contact
    unchanged = new.master.impedance == old.master.impedance
    if unchanged or own.impedance is not None or own.impedance_matrix.strip():
        return new
    if own is not old.contact or isinstance(old.server_impedance, MatrixImpedance):
        return new
    return replace(new, contact=replace(own, impedance=old.server_impedance))  # type: ignore[arg-type]


def why_fixed(name: str, *, strict: bool, server: ServerParams, coupling: Coupling) -> str:
    """Return why a rate cannot change with this channel, server, coupling; "" if it can."""
    if name in (RATE_DROP, PERIOD) and not strict:
        return NEEDS_STRICT
    if name == PERIOD and (coupling.moves or server.integrator) != "backward_euler":
        return (
            f"is fixed with server.coupling = {coupling.name}, server.integrator = "
            f"{server.integrator}: avatars move by the velocity of the step before"
        )
    return ""
