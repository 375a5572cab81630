# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings of the server as linear maps: contacts in touch, object and wave ports.

The equations are those of :mod:`pmwvc_core.server.couplings`, written out for two-sided contacts
(f = K e + B (xd_s - xd_o), e the deflection of the spring) and applied to rows. ``carried`` is the
cube of :mod:`pmwvc_core.server.black_box.touch`: decoded late, then moved by the midpoint rule.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from oracle.linear_model.blocks import column
from oracle.linear_model.motion import motion

from pmwvc_core.law.server import coupling as sampled
from pmwvc_core.numeric import Array
from pmwvc_core.params import ServerParams


@dataclass
class Seat:
    """One user: parameters as columns, signals as rows; ``names``: needed in the next step."""

    stiffness: Array
    damping: Array
    b: Array
    names: tuple[str, ...]
    weight: int  # how many users like this one move together
    spring: tuple[Array, Array]  # stiffness and damping of a virtual coupling
    ratio: Array = field(init=False)
    rows: dict[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Form sqrt(2/b)."""
        self.ratio = np.sqrt(2.0 / self.b)

    @property
    def state(self) -> list[Array]:
        """One row per name."""
        return [self.rows[name] for name in self.names]

    @state.setter
    def state(self, rows: list[Array]) -> None:
        self.rows.update(zip(self.names, rows, strict=True))

    def steady(self, u: Array, e: Array) -> list[Array]:
        """Return the states in uniform motion, with waves u both ways and a deflection e that
        exerts no force.
        """
        values = {"e": e, "f": 0.0 * u, "xd_s": self.ratio * u}
        return [values[name] for name in self.names]


class Wall:
    """An object that never moves."""

    names: tuple[str, ...] = ()

    def __init__(self) -> None:
        self.state: list[Array] = []
        self.velocity: Array = np.zeros((1, 1))

    def push(self, force: Array) -> Array:
        """Stay; return the displacement."""
        return 0.0 * force

    def mean_velocity(self, force: Array, slope: Array) -> Array:
        """Return zero."""
        return 0.0 * force

    def drift(self, velocity: Array) -> None:
        """Stay."""


class Cube:
    """m x'' + b x' = force, exact under held forces or by the midpoint rule."""

    names: tuple[str, ...] = ("x_o", "xd_o")

    def __init__(self, params: ServerParams) -> None:
        mass, damping = column(params.object_mass), column(params.object_damping)
        self._motion = motion(mass, damping, params.period_s)
        self._period = params.period_s
        self._inertance = 2.0 * mass / params.period_s
        self._damping = damping
        self.state: list[Array] = []

    @property
    def velocity(self) -> Array:
        """Row of the velocity [m/s]."""
        return self.state[1]

    def push(self, force: Array) -> Array:
        """Go one step on under a held force; return the displacement."""
        x, xd = self.state
        moved = self._motion.xd_x * xd + self._motion.f_x * force
        self.state = [x + moved, self._motion.xd_xd * xd + self._motion.f_xd * force]
        return moved

    def mean_velocity(self, force: Array, slope: Array) -> Array:
        """Return v of m (v1 - v0)/h + b v = force - slope v, v = (v0 + v1)/2."""
        inflow = self._inertance * self.velocity + force
        return inflow / (self._inertance + self._damping + slope)

    def drift(self, velocity: Array) -> None:
        """Go one step on at a mean velocity."""
        x, xd = self.state
        self.state = [x + self._period * velocity, 2.0 * velocity - xd]


Body = Wall | Cube


def _implicit(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    h = params.period_s
    force: Array = np.zeros((1, 1))
    slope: Array = np.zeros((1, 1))
    for seat in seats:
        gain = 0.5 * h * seat.stiffness + seat.damping
        share = 1.0 + gain / seat.b
        free = seat.ratio * seat.rows["u"]
        seat.rows["gripping"] = (seat.stiffness * seat.rows["e"] + gain * free) / share
        force = force + seat.weight * seat.rows["gripping"]
        slope = slope + seat.weight * gain / share
    velocity = body.mean_velocity(force, slope)
    for seat in seats:
        gain = 0.5 * h * seat.stiffness + seat.damping
        seat.rows["f"] = seat.rows["gripping"] - gain / (1.0 + gain / seat.b) * velocity
        xd_s = seat.ratio * seat.rows["u"] - seat.rows["f"] / seat.b
        seat.rows["e"] = seat.rows["e"] + h * (xd_s - velocity)
    body.drift(velocity)


def _sum_of_forces(seats: Sequence[Seat]) -> Array:
    return sum((seat.weight * seat.rows["f"] for seat in seats), start=np.zeros((1, 1)))


def _push(seats: Sequence[Seat], body: Body) -> None:
    force = _sum_of_forces(seats)
    moved = body.push(force)
    for seat in seats:
        seat.rows["e"] = seat.rows["e"] - moved


def _one_step_delay(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    old, new = sampled.weights(params.integrator, params.period_s)
    _push(seats, body)
    for seat in seats:
        rows = seat.rows
        xd_s = seat.ratio * rows["u"] - rows["f"] / seat.b
        rows["e"] = rows["e"] + new * xd_s
        if old:
            rows["e"] = rows["e"] + old * rows["xd_s"]
        rows["xd_s"] = xd_s
        rows["f"] = seat.stiffness * rows["e"] + seat.damping * (xd_s - body.velocity)


def _one_frame_late(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    for seat in seats:
        rows = seat.rows
        rows["f"] = seat.stiffness * rows["e"] + seat.damping * (rows["xd_s"] - body.velocity)
        rows["e"] = rows["e"] + params.period_s * rows["xd_s"]
        rows["xd_s"] = seat.ratio * rows["u"] - rows["f"] / seat.b
    _push(seats, body)


def _unwrapped(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    old, new = sampled.weights(params.integrator, params.period_s)
    _push(seats, body)
    for seat in seats:
        rows = seat.rows
        if old:
            rows["e"] = rows["e"] + old * rows["xd_s"]
        gain = seat.damping + new * seat.stiffness
        free = seat.ratio * rows["u"]
        loose = seat.stiffness * rows["e"] + gain * free - seat.damping * body.velocity
        rows["f"] = loose / (1.0 + gain / seat.b)
        rows["xd_s"] = free - rows["f"] / seat.b
        rows["e"] = rows["e"] + new * rows["xd_s"]


def _carried(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    old, new = sampled.weights(params.integrator, params.period_s)
    h = params.period_s
    force, slope = np.zeros((1, 1)), np.zeros((1, 1))
    for seat in seats:
        rows, gain = seat.rows, 0.5 * h * seat.stiffness + seat.damping
        xd_s = seat.ratio * rows["u"] - rows["f"] / seat.b
        rows["rate"] = (old / h * rows["xd_s"] if old else 0.0) + new / h * xd_s
        rows["xd_s"] = xd_s
        force = force + seat.weight * (seat.stiffness * rows["e"] + gain * rows["rate"])
        slope = slope + seat.weight * gain
    velocity = body.mean_velocity(force, slope)
    for seat in seats:
        rows, gain = seat.rows, 0.5 * h * seat.stiffness + seat.damping
        rows["f"] = seat.stiffness * rows["e"] + gain * (rows["rate"] - velocity)
        rows["e"] = rows["e"] + h * (rows["rate"] - velocity)
    body.drift(velocity)


def _direct(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    force = _sum_of_forces(seats)
    body.push(force)
    for seat in seats:
        x, xd = seat.rows["x"], seat.rows["xd"]
        e = x - (body.state[0] if body.state else 0.0 * x)
        seat.rows["f"] = seat.stiffness * e + seat.damping * (xd - body.velocity)


def _virtual_coupling(seats: Sequence[Seat], body: Body, params: ServerParams) -> None:
    h = params.period_s
    _push(seats, body)
    for seat in seats:
        rows = seat.rows
        place = rows["e"] + (body.state[0] if body.state else 0.0 * rows["e"])
        stiffness, damping = seat.spring
        impedance = stiffness * h + damping
        free = (stiffness * (rows["x"] - place) + damping * rows["xd"]) / impedance
        gain = seat.damping + h * seat.stiffness
        loose = seat.stiffness * rows["e"] + gain * free - seat.damping * body.velocity
        rows["f"] = loose / (1.0 + gain / impedance)
        rows["e"] = rows["e"] + h * (free - rows["f"] / impedance)


Law = Callable[[Sequence[Seat], Body, ServerParams], None]
LAWS: Mapping[str, Law] = {
    "implicit": _implicit,
    "one_step_delay": _one_step_delay,
    "one_frame_late": _one_frame_late,
    "unwrapped": _unwrapped,
    "carried": _carried,
    "direct": _direct,
    "virtual_coupling": _virtual_coupling,
}
REMEMBERED: Mapping[str, tuple[str, ...]] = {  # the others: by the integrator
    "direct": ("f",),
    "implicit": ("e",),
    "virtual_coupling": ("e", "f"),
    "one_frame_late": ("e", "xd_s"),
}


def remembered(law: str, integrator: str) -> tuple[str, ...]:
    """Return which signals of a seat a law needs in its next step."""
    if law in REMEMBERED:
        return REMEMBERED[law]
    return ("e", "f") if integrator == "backward_euler" else ("e", "f", "xd_s")
