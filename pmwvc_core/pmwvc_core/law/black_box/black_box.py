# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end for an environment of which nothing is known but its answers (App. C).

::

    xd(n) = [sqrt(2/b) u(n) - F0/b]/(1 + G/b)         with the line F' = F0 + G xd
    F(n)  = environment(x(n), xd(n)),   v(n) = u(n) - sqrt(2/b) F(n)

The line is the environment's own where it reports its slope, else the learned one (:mod:`.secant`)
or F' = F(n-1) (``late``). (|u|^2 - |v|^2)/2 = F . xd + d with d = F . (sqrt(2/b) u - F/b - xd),
the power of decoding with another force than F, which :mod:`.compensations` treat. The waves move
the device by T (u + v')/sqrt(2b), the avatar moves by T xd; a port that learns repays 0.3 of the
difference in the next step. Equations: docs/theory.md 5.1, 5.2, 5.9, 5.12.
"""

from operator import add
from typing import Any, NamedTuple

from pmwvc_core.law.black_box.compensations import Pair, Terms, compensated
from pmwvc_core.law.black_box.secant import Seen, checked, guess, learned, noted, ratio_in_use
from pmwvc_core.law.black_box.touched import Visitors, exchange, moved_on, touches, visited
from pmwvc_core.law.family import accounts
from pmwvc_core.law.motion import BodyLaw
from pmwvc_core.law.safety.brakes import unbraked
from pmwvc_core.law.server import server_port
from pmwvc_core.law.server.contacts import Avatar, slid
from pmwvc_core.law.server.server_port import Came, SharedScene, UserPort, brakes_j, taken_port
from pmwvc_core.law.vectors import Vector, columns, dot, each, length, minus, plus, scaled, zero
from pmwvc_core.law.wave.wave import Rows, damper, free_velocity, wave_j, wave_v, wave_velocity

MEMORY_S = 0.5  # in which the longest way fades


class Accounts(NamedTuple):
    """Energies since the start [J]; in all what went in at the ports, less the brakes' heat."""

    environment_j: float  # sum F . xd h
    late_j: float  # decoding with another force than F
    withheld_j: float  # what the compensation took from the returning waves; negative: added
    contained_j: float  # of the damper while the environment did not answer


class BoxState(NamedTuple):
    """The environment behind its ports, and the object that it shows."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    environment: Any
    compensation: Any
    users: tuple[Seen, ...]
    way_m: float  # longest one of late, fading
    stored_j: float  # in the environment; below zero where it does not report it
    accounts: Accounts


class BlackBoxParams(NamedTuple):
    """Parameters of a black box and its ports."""

    environment: Any
    compensation: Terms
    body: BodyLaw  # its period is the time step
    brakes: Rows  # of an avatar: 1 for each axis that one holds, else 0
    old_s: float  # weights of old and new velocity in an avatar's displacement
    new_s: float
    sloped: bool  # the environment reports its slope
    learns: bool  # the port does
    identity: Rows  # of the axes


@server_port.environment_step.member(BlackBoxParams)
def _step(p: BlackBoxParams, s: SharedScene, came: tuple[Came, ...]) -> SharedScene:
    box, h = s.body, p.body.period_s
    ports, avatars = columns(each(taken_port, (s.ports, came), p))
    users, there, begins, at = columns(each(noted, (box.users, s.ports)))
    environment = visited(box.environment, there, begins, at)
    starts = each(moved_on, (avatars, at), p.old_s)
    users, velocities = columns(each(guess, (users, ports, starts), p))
    environment, reply = exchange(environment, Visitors(avatars, at, starts), velocities, p)
    way_m, stored_j, x, xd = box.way_m, box.stored_j, box.x, box.xd
    if reply.answered:
        way_m = max(way_m * max(1.0 - h / MEMORY_S, 0.0), length(xd) * h)
        for i in range(len(users)):
            way_m = max(way_m, length(minus(reply.ends[i], users[i].at)))
        learns = p.learns and not reply.solved
        users = each(checked, (users, reply.ends, reply.avatars), way_m, learns, h)
        stored_j, x, xd = reply.stored_j, reply.x, reply.xd
    replies = (users, ports, starts, reply.avatars, reply.ends)
    ports, waves, sums = columns(each(_taken, replies, reply.answered, p))
    held_j = stored_j if stored_j < 0.0 else _held(stored_j, users, s.ports, ports, p)
    compensation, returned = compensated(box.compensation, waves, held_j, p.compensation)
    ports = each(_give, (s.ports, ports, came, returned), p)
    energies = box.accounts
    for i in range(len(waves)):
        withheld_j = wave_j(waves[i].v, h) - wave_j(returned[i], h)
        energies = Accounts(*each(add, (energies, sums[i]._replace(withheld_j=withheld_j))))
    box = BoxState(x, xd, environment, compensation, users, way_m, stored_j, energies)
    spent_j = energies.environment_j + energies.contained_j - max(stored_j, 0.0)
    return SharedScene(ports, box, spent_j, s.unsettled)


def _taken(
    s: Seen, port: UserPort, start: Vector, moved: Avatar, x_s: Vector, answered: bool,
    p: BlackBoxParams,
) -> tuple[UserPort, Pair, Accounts]:  # fmt: skip
    """Give a port velocity and force; return its waves, zero where it is contained, and sums."""
    a, h, rest = port.avatar, p.body.period_s, zero(start)
    velocity, force, contact = moved.xd, moved.f, moved.contact
    if not a.present:
        return port, Pair(rest, rest, 0.0), Accounts(0.0, 0.0, 0.0, 0.0)
    if answered and s.usable and not s.jumped:
        exact = wave_velocity(a.impedance, a.u, force)
        late_w = dot(force, minus(exact, velocity))
        wave = Pair(a.u, wave_v(a.impedance, a.u, force), late_w)
        sums = Accounts(h * dot(force, velocity), h * late_w, 0.0, 0.0)
    else:
        velocity = scaled(free_velocity(a.impedance, a.u), 0.5)
        force, wave = damper(a.impedance, velocity), Pair(rest, rest, 0.0)
        end, x_s = x_s, plus(start, scaled(velocity, p.new_s))
        contact, _ = slid(contact, minus(x_s, end))
        sums = Accounts(0.0, 0.0, 0.0, wave_j(a.u, h))
    avatar = a._replace(xd=velocity, f=force, contact=contact)
    return port._replace(avatar=avatar, x_s=x_s), wave, sums


def _held(
    stored_j: float, users: tuple[Seen, ...], before: tuple[UserPort, ...],
    ports: tuple[UserPort, ...], p: BlackBoxParams,
) -> float:  # fmt: skip
    """Return what can still come out [J]: what is stored, up to G/b times that with a slope, and
    |F|^2 h/(2b), which decoding with F(n-1) took while a force built up.
    """
    most, late_j = 0.0, 0.0
    for i in range(len(ports)):
        if p.learns:
            most = max(most, ratio_in_use(users[i].secant))
        f = ports[i].avatar.f
        late_j -= dot(f, wave_velocity(before[i].avatar.impedance, zero(f), f))
    held_j = stored_j * (1.0 + most * p.new_s / p.body.period_s)
    return held_j + 0.5 * p.body.period_s * late_j


def _give(
    before: UserPort, port: UserPort, came: Came, v_s: Vector, p: BlackBoxParams
) -> UserPort:
    a, b, h, wave = port.avatar, before.avatar.impedance, p.body.period_s, came.wave
    if not a.present:
        return port
    brake, _, v_s = unbraked(port.brake, a.impedance, wave, a.u, v_s, h, p.brakes)
    if p.learns:
        late = minus(scaled(free_velocity(b, plus(wave, v_s)), 0.5), a.xd)
        a = a._replace(kept=plus(a.kept, scaled(late, h)))
    avatar = a._replace(impedance=b, u=wave)
    u_j, v_j = port.u_j + wave_j(wave, h), port.v_j + wave_j(v_s, h)
    return port._replace(avatar=avatar, brake=brake, v_s=v_s, u_j=u_j, v_j=v_j)


@server_port.scene_energies.member(BlackBoxParams)
def _energies(p: BlackBoxParams, s: SharedScene) -> Vector:
    e = s.body.accounts
    stored: Vector = (
        0.0, max(s.body.stored_j, 0.0), e.environment_j, e.late_j, e.withheld_j, e.contained_j
    )  # fmt: skip
    return stored + accounts(s.body.compensation, p.compensation) + (brakes_j(s.ports),)


@server_port.port_shown.member(BlackBoxParams)
def _shown(p: BlackBoxParams, s: SharedScene, user: int) -> server_port.PortShown:
    port = s.ports[user]
    a = port.avatar
    in_touch = a.present and touches(s.body.environment, user, a.f != zero(a.f))
    ratio = learned(s.body.users[user].secant) if p.learns else 0.0
    return server_port.PortShown(port.v_s, in_touch, ratio)
