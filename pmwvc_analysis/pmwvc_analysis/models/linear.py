# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nonlinear elements of a scenario, its nearest linear one, and the effects left out."""

import dataclasses
from collections.abc import Iterator
from typing import Any, NamedTuple

from pmwvc_core.controllers.library import PLAIN, RECORDS, ZEROING, has_waves, record_of
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.effects import active, amounts
from pmwvc_core.params import specs
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.server.environments import environment_of
from pmwvc_core.wave.impedance import MatrixImpedance

ALWAYS = (  # said of every scenario
    "Grips and other contacts are modelled as two-sided, local models as always in contact: valid "
    "while all users touch.",
    "Hands are modelled as applied forces; limits and changes of parameters are not modelled.",
)
AMPLITUDE = 2.0**-7  # of a motion [m, m/s, N, sqrt(W)], at which a model still holds


class Element(NamedTuple):
    """An element that no linear model covers."""

    text: str  # name and value
    name: str  # of the parameter, as for --set
    instead: Any  # its value in the nearest linear scenario; None: there is none

    @property
    def setting(self) -> str:
        """What makes it linear, as for ``--set``."""
        return f"{self.name}={self.instead}"


class Relative(NamedTuple):
    """The nearest linear scenario, and the settings by which it differs."""

    scenario: Scenario
    settings: list[str]


class NonlinearError(PmwvcError, ValueError):
    """A linear model was asked of something that is not linear."""


def outside(scenario: Scenario) -> list[str]:
    """Return what of both ends comes from other packages and has a linear model of its own."""
    compensation = COMPENSATIONS.of(scenario.server.compensation)
    parts = (
        ("controller", RECORDS.library, record_of(scenario.controller)),
        ("server.coupling", COUPLINGS.library, scenario.coupling),
        ("server.compensation", COMPENSATIONS.library, compensation),
    )
    return [
        f"{parameter} = {record.name}"
        for parameter, library, record in parts
        if record.name not in library and record.linear == record.name
    ]


def nonlinear(scenario: Scenario) -> list[Element]:
    """Return everything in a scenario that is not linear, or that has no linear model."""
    return [*_of_controller(scenario), *_of_users(scenario)]


def axes_of(scenario: Scenario) -> int:
    """Return the number of axes of the model: the scenario's where an impedance matrix couples
    them; else one, as all axes have the same model.
    """
    if not has_waves(scenario.controller):
        return 1
    ends = (b for user in scenario.users for b in (user.impedance, user.server_impedance))
    return scenario.dof if any(isinstance(b, MatrixImpedance) for b in ends) else 1


def require_linear(scenario: Scenario) -> None:
    """Raise NonlinearError for elements without a linear model, with what to ask instead."""
    found = nonlinear(scenario)
    alone = [element.text for element in found if element.instead is None]
    if alone:
        raise NonlinearError(
            f"{scenario.name}: {', '.join(alone)}: has no linear model, and none is near; use "
            "'pmwvc simulate'"
        )
    if found:
        settings = " ".join(dict.fromkeys(f"--set {element.setting}" for element in found))
        raise NonlinearError(
            f"{scenario.name} is not linear: {', '.join(element.text for element in found)}; ask "
            f"for the nearest linear scenario with {settings}, or use 'pmwvc simulate'"
        )


def relative(scenario: Scenario) -> Relative | None:
    """Return the nearest linear scenario; None where it is linear already, or none is near."""
    found = nonlinear(scenario)
    if not found or any(element.instead is None for element in found):
        return None
    changed = scenario
    for _, name, instead in found:
        if name in ("controller", "channel"):
            changed = dataclasses.replace(changed, **{name: instead})
        else:
            changed = varied(changed, name, instead)
    return Relative(changed, list(dict.fromkeys(element.setting for element in found)))


def _element(name: str, value: object, instead: Any, *, user: str = "", unit: str = "") -> Element:
    """Return the element that a parameter has with a value, of a user or of all."""
    return Element(f"{user}{name} = {value} {unit}".rstrip(), name, instead)


def _of_controller(scenario: Scenario) -> Iterator[Element]:
    server, controller, coupling = scenario.server, scenario.controller, scenario.coupling
    if (record := record_of(controller)).linear != controller:
        yield _element("controller", controller, record.linear)
    if scenario.zeroing:
        yield _element("channel", ZEROING, PLAIN)
    if coupling.linear != coupling.name and has_waves(controller):
        yield _element("server.coupling", coupling.name, coupling.linear)
    if not coupling.black_box:
        return
    compensation, environment = COMPENSATIONS.of(server.compensation), scenario.environment
    if compensation.linear != compensation.name:
        yield _element("server.compensation", compensation.name, compensation.linear)
    if environment.linear != environment.name:
        nearest = environment_of(str(environment.linear))
        instead = (server.learns and nearest.with_slope) or environment.linear
        yield _element("server.environment", environment.name, instead)
    elif server.learns and not environment.sloped:
        slope = environment.with_slope
        near = ("server.environment", slope) if slope else ("server.decoding", "late")
        yield Element("server.decoding = secant (a learned slope)", *near)


def _of_users(scenario: Scenario) -> Iterator[Element]:
    for user in scenario.users:
        of: dict[str, Any] = {"user": f"{user.name}."}
        for name, unit in (("friction", "N"), ("encoder_step_m", "m")):
            value = getattr(user.device, name)
            if value > 0.0:
                yield _element(f"device.{name}", value, 0, unit=unit, **of)
        for group, port in (("master", user.master), ("server", user.contact)):
            if port.deadband.is_on:
                yield _element(f"{group}.deadband.kind", port.deadband.kind, "none", **of)
        for way, link in (("up", user.link_up), ("down", user.link_down)):
            for effect in active(link):
                if effect.linear is None:
                    parameter, off = effect.switch
                    unit = specs(type(link))[parameter].unit.replace("-", "")
                    value = getattr(link, parameter)
                    yield _element(f"link.{way}.{parameter}", value, off, unit=unit, **of)
        position = user.master.position
        if position.adapts:
            yield _element("master.position.adapts", "true", False, **of)
        if position.is_paid:
            near = "none" if scenario.strict else "printed"
            yield _element("master.position.feedback", position.feedback, near, **of)


def notes_of(scenario: Scenario) -> list[str]:
    """Return, in sentences, where the linear model stands for something else."""
    notes = [*outside_words(scenario), *ALWAYS]
    if effects := "; ".join(left_out(scenario)):
        notes.append(f"Left out, as every packet takes delay_s: {effects}.")
    if scenario.dof > axes_of(scenario):
        notes.append("One axis is analysed: all axes have the same model.")
    return notes


def outside_words(scenario: Scenario) -> list[str]:
    """Return what the model of code from other packages rests on, in sentences."""
    most = f"{1e3 * AMPLITUDE:.1g} mm, mm/s or mN"
    return [
        f"{each} comes from another package: its model is that of signals of up to "
        f"{most}; beyond that it is not known."
        for each in outside(scenario)
    ]


def left_out(scenario: Scenario) -> list[str]:
    """Return the effects of links that no linear model has, each with its amount and its users."""
    found: dict[str, list[str]] = {}
    for user in scenario.users:
        for way, link in (("up", user.link_up), ("down", user.link_down)):
            for effect in amounts(link).values():
                found.setdefault(effect, []).append(f"{user.name} {way}")
    return [f"{effect} ({', '.join(where)})" for effect, where in found.items()]
