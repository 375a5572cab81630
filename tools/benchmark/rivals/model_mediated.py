# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Model-mediated teleoperation (Mitra and Niemeyer 2008; Xu, Cizmeci, Al-Nuaimi and Steinbach
2014): the server sends the parameters of its surroundings, the device renders them without delay.

Server: K by least squares with forgetting, from the force f and the depth e of the position
commanded, while in touch; p: where the surface is. Device: the model, one-sided like the contact::

    K = (sum q^i f e)/(sum q^i e^2)          F = K (x - p) + B xd   inside, else 0

Parameters change step by step over ``update_s``, without a step of force, and only as far as a
tank can pay for what the change adds to the model's spring::

    dE = K'/2 |x - p'|^2 - K/2 |x - p|^2 <= tank
    tank: + work - change of the spring (heat of B) + what the avatar has taken in, up to cap_j

so the device's port never gives out more than it took in and the avatar took in, whatever comes.

Adapted: the papers' surface is at rest, seen by a camera or found at contact; here it belongs to
an object that moves, and its place and side are those of the simulator, as a camera would give
them. What moves it against the hand is paid by the energy that the avatar took in at the object.
Across the surface the model is a spring about the place of first contact while the avatar
touches. The avatar is a robot with a supply of its own, pulled to the device's position by spring
and damper, whose give is in K. Passivity of updates is after the idea of Xu et al. (ICME 2015).

The papers were not at hand: their estimators (normals, friction) and gains are not used.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from benchmark.rivals.energy import Place, Received, received, released_j, work_j
from pmwvc_core.controllers.plugged import (
    AvatarAnswer,
    AvatarStep,
    DeviceAnswer,
    DeviceTick,
    pulled_avatar,
)
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.server.contacts import Contact, touching
from pmwvc_core.law.vectors import Vector, between, minus, plus, scaled, squared, zero
from pmwvc_core.params.fields import Validated, parameter

KEPT = 0.98  # q: of older samples at every step
LEAST_M = 1e-4  # of depth, to estimate with
HALVINGS = 12
RANGES = {
    "damping": (0.5, 15.0),
    "update_s": (0.002, 0.1),
    "guess": (100.0, 1000.0),
    "cap_j": (1e-3, 0.3),
    "stiffness": (500.0, 10000.0),
    "coupling_damping": (1.0, 30.0),
}


@dataclass(frozen=True)
class Gains(Validated):
    """Both ends."""

    damping: float = parameter(3.0, ">= 0 N s/m", "damping of the model (rule: > K T_c/2)")
    update_s: float = parameter(0.01, "> 0 s", "time in which the model follows its parameters")
    guess: float = parameter(300.0, "> 0 N/m", "stiffness until it is estimated")
    cap_j: float = parameter(0.05, ">= 0 J", "most that the tank keeps")
    stiffness: float = parameter(2000.0, "> 0 N/m", "spring of the avatar to the device")
    coupling_damping: float = parameter(10.0, ">= 0 N s/m", "damper beside it")


class Model(NamedTuple):
    """Parameters of the model: stiffness [N/m], also across, surface [m], side (0: two)."""

    stiffness: float
    across: float
    surface: Vector
    inward: float


class DeviceEnd(NamedTuple):
    """The device's end."""

    model: Model
    spring_j: float = 0.0
    tank_j: float = 0.0
    came: Received = Received()
    place: Place = Place()


class Estimate(NamedTuple):
    """The avatar's end: sums of the least squares, energy taken in [J]."""

    fe: float = 0.0
    ee: float = 0.0
    taken_j: float = 0.0


def pull(m: Model, x: Vector) -> Vector:
    """Return the force of the model's spring [N]; outside the surface none."""
    way = minus(x, m.surface)
    if m.inward * way[0] < 0.0:
        return zero(x)
    return (m.stiffness * way[0], *(m.across * each for each in way[1:]))


def spring_j(m: Model, x: Vector) -> float:
    """Return the energy of the model's spring [J]."""
    force, way = pull(m, x), minus(x, m.surface)
    return 0.5 * sum(f * d for f, d in zip(force, way, strict=True))


def followed(m: Model, aim: Model, x: Vector, share: float, tank_j: float) -> Model:
    """Move the parameters towards those received as far as the tank can pay."""
    if spring_j(m, x) == 0.0 and spring_j(aim, x) == 0.0:
        return aim  # nothing is felt
    before = spring_j(m, x)
    for _ in range(HALVINGS):
        after = Model(
            m.stiffness + share * (aim.stiffness - m.stiffness),
            m.across + share * (aim.across - m.across),
            between(m.surface, aim.surface, share),
            aim.inward,
        )
        if spring_j(after, x) - before <= tank_j:
            return after
        share *= 0.5
    return m


def device(s: DeviceEnd, tick: DeviceTick, p: Gains) -> tuple[DeviceEnd, DeviceAnswer]:
    """Count the last tick, change the model, render it."""
    place, work = work_j(s.place, tick)
    m, came = s.model, s.came
    tank_j, held_j = s.tank_j + work - (spring_j(m, tick.x) - s.spring_j), spring_j(m, tick.x)
    if tick.packet.number > 0:
        stiffness, across, inward, sum_j = tick.packet.extra
        came, gained = received(came, sum_j)
        tank_j += gained
        aim = Model(stiffness, across, tick.packet.wave, inward)
        if tick.silent:
            aim = m._replace(stiffness=0.0, across=0.0)
        share = tick.tick_s / (tick.tick_s + p.update_s)
        m = followed(m, aim, tick.x, share, max(tank_j, 0.0))
    after_j = spring_j(m, tick.x)
    tank_j = min(tank_j - (after_j - held_j), p.cap_j)
    force = pull(m, tick.x)
    if squared(force) > 0.0:
        force = pushed(m, plus(force, scaled(tick.xd, p.damping)))
    s = DeviceEnd(m, after_j, tank_j, came, place)
    return s, DeviceAnswer(force, tick.xd)


def pushed(m: Model, force: Vector) -> Vector:
    """Return the force that a surface can exert: a one-sided one never pulls."""
    return zero(force) if m.inward * force[0] < 0.0 else force


def avatar(s: Estimate, step: AvatarStep, p: Gains) -> tuple[Estimate, AvatarAnswer]:
    """Pull the avatar to the device, estimate, send the parameters."""
    spring = scaled(minus(step.position, step.x_s), p.stiffness)
    drive = plus(spring, scaled(step.wave, p.coupling_damping))
    moved = pulled_avatar(step, drive, p.stiffness * step.period_s + p.coupling_damping)
    contact: Contact = moved.contact
    rests = tuple(each.rest for each in contact.springs)
    surface, one_sided = plus(step.body.x, rests), contact.springs[0].one_sided
    inward = contact.law.inward if one_sided else 0.0
    fe, ee, depth = s.fe, s.ee, step.position[0] - surface[0]
    if abs(depth) > LEAST_M and moved.f[0] * depth > 0.0:
        fe, ee = KEPT * fe + moved.f[0] * depth, KEPT * ee + depth * depth
    stiffness = fe / ee if ee > 0.0 else p.guess
    across = stiffness if touching(contact) else 0.0
    s = Estimate(fe, ee, s.taken_j + max(-released_j(step, moved), 0.0))
    extra = (stiffness, across, inward, s.taken_j)
    return s, AvatarAnswer(moved, minus(surface, step.offset), extra)


def _rest(p: Any, axes: int) -> DeviceEnd:
    return DeviceEnd(Model(0.0, 0.0, (0.0,) * axes, 0.0))


MODEL_MEDIATED = Controller(
    name="model_mediated",
    words="Model-mediated: the device renders a local model; its updates are paid for.",
    waves=False,
    device=device,
    avatar=avatar,
    device_rest=_rest,
    avatar_rest=lambda p, axes: Estimate(),
    extra=lambda axes: (0, 4),
    params=Gains,
    coupling=HELD,
)
