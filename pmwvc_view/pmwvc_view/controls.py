# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that a page may change: nothing else of a session can be reached from there."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from pmwvc_core.controllers.library import RECORDS, record_of
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.scenario.names import PERIOD, RATE_DROP, resolved, spec_of, split_user
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario

Setting = float | str | bool
Settings = Mapping[str, Setting]
PRESET = "link.preset"
CONTROLLER, CHANNEL = "controller", "channel"
IMPEDANCE = "master.impedance"
AT_RESTART = (CONTROLLER, CHANNEL)  # changes with a new beginning only


class Control(NamedTuple):
    """A parameter that a page may change: its name in a scenario. ``ends`` are those of a slider;
    values beyond are allowed as far as the parameter's range goes. None for a name.
    """

    path: str
    label: str
    ends: tuple[float, float] | None = None


CONTROLS = (
    Control(PRESET, "network"),
    Control("link.delay_s", "delay, each way", (0.0, 0.1)),
    Control("link.jitter_s", "jitter", (0.0, 0.02)),
    Control("link.jitter", "kind of jitter"),
    Control("link.loss", "loss", (0.0, 0.3)),
    Control("server.contact_stiffness", "contact stiffness K", (50.0, 3000.0)),
    Control("server.contact_damping", "contact damping B", (0.0, 50.0)),
    Control("server.object_damping", "damping of the object", (0.0, 50.0)),
    Control("server.object_mass", "mass of the object", (0.2, 5.0)),
    Control(IMPEDANCE, "wave impedance b", (5.0, 100.0)),
    Control(RATE_DROP, "ticks per packet M", (1.0, 100.0)),
    Control(PERIOD, "period of the server", (0.001, 0.1)),
    Control(CONTROLLER, "controller"),
    Control(CHANNEL, "channel of the waves"),
)
_BY_PATH = {control.path: control for control in CONTROLS}


def control_of(path: str) -> Control:
    """Return the control of a path, which may name a user; ParameterError where there is none."""
    number, rest = split_user(path)
    if rest not in _BY_PATH or (number and rest in AT_RESTART):
        raise ParameterError(f"{path}: cannot be changed here")
    return _BY_PATH[rest]


def changed(scenario: Scenario, values: Settings) -> Scenario:
    """Return a scenario with settings of a page; ParameterError where one of them is refused."""
    for path in values:
        control_of(path)
    wanted: dict[str, Any] = dict(values)
    if IMPEDANCE in wanted:  # of both ends
        wanted["server.impedance"] = wanted[IMPEDANCE]
    names = [user.name for user in scenario.users]
    numbered = renamed(scenario, [f"user{i}" for i in range(1, len(names) + 1)])
    try:
        return renamed(parse_scenario(numbered.to_dict(), overrides=wanted), names)
    except ScenarioError as error:
        raise ParameterError("; ".join(error.problems)) from None


def renamed(scenario: Scenario, names: Sequence[str]) -> Scenario:
    """Return a scenario whose users have other names; a scenario file numbers them."""
    users = zip(scenario.users, names, strict=True)
    return replace(scenario, users=tuple(replace(user, name=name) for user, name in users))


def values_of(scenario: Scenario, preset: str | None = None) -> dict[str, Any]:
    """Return the value of every control: the first user's, and the uplink's, where they differ."""
    flat = scenario.flat()
    found = {PRESET: preset, CONTROLLER: scenario.controller, CHANNEL: scenario.channel}
    for control in CONTROLS:
        if control.path not in found:
            leaf = resolved(control.path)[1][0]
            first = f"{scenario.users[0].name}.{leaf}"
            found[control.path] = flat[leaf] if leaf in flat else flat.get(first)
    return found


def to_page(values: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the controls, with these values, as the session message declares them."""
    return [
        {
            "path": path,
            "label": control.label,
            "unit": "-" if path == PRESET else spec_of(path).unit,
            "value": values[path],
            "slider": list(control.ends) if control.ends else None,
            "choices": None if control.ends else list(_choices(control)),
            "restart": path in AT_RESTART,
        }
        for path, control in _BY_PATH.items()
    ]


def _choices(control: Control) -> Iterator[dict[str, str]]:
    """Yield the names that a parameter may have, with words."""
    if control.path == PRESET:
        yield from ({"name": name, "words": each.basis} for name, each in PRESETS.items())
    elif control.path == CONTROLLER:
        for name in RECORDS.names():
            with contextlib.suppress(ParameterError):  # a plug-in that cannot be used
                yield {"name": name, "words": record_of(name).words}
    else:
        yield from ({"name": name, "words": ""} for name in spec_of(control.path).choices)
