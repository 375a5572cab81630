# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What reaches the device, for whatever a controller asks, including values that are not numbers.
Research software: not a certified safeguard.

* the force starts at zero, changes by at most ``max_slew * tick_s`` in a tick and is never longer
  than ``max_force`` (a vector keeps its direction);
* after a start, another server or any recovery it grows from zero over ``soft_start_s``, after a
  silence of the same server from what had not faded, within ``RETURN_S`` (at once with a brake);
  what acted before another server came, or the loop stood still, goes over within ``FADE_S``;
* **damping**: when the server has been silent for longer than ``timeout_s`` or three packets, or
  the device is faster than ``damper_velocity``, only the part that opposes the motion remains;
  what pushes fades over ``FADE_S`` (at once above the speed). After ``release_s`` damping and
  brake are let go over ``LET_GO_S``;
* **workspace**: where the device says it is beyond its own, damping likewise;
* **device silent**: no force; after ``LOST_S`` a fault. Values that are not finite count as zero;
* **fault**: above ``fault_velocity``, or where the device was lost, no force until ``rearm``.

Of six axes force and torque are each limited, damped for their own speed, and braked. The brake
holds the hand on the strict channel (:mod:`.brakes`). Equations: docs/theory.md 10.2.
"""

from typing import NamedTuple

from pmwvc_core.law.safety.brakes import HandBrake, brake_limit, hand_braked, loose_brake
from pmwvc_core.law.vectors import (
    Vector,
    columns,
    dot,
    each,
    measured,
    minus,
    plus,
    scaled,
    shortened,
    times,
    zero,
)

LOST_S = 1.0
# Causes of the state of the limits:
NONE, WAITING, SOFT_START, SILENT, RELEASED, TOO_FAST, NOT_FINITE, RUNAWAY = range(8)
OUTSIDE, DEVICE_SILENT, DEVICE_LOST, UNRECEIVED, LATE = range(8, 13)
FADE_S, LET_GO_S = 0.02, 0.5
RETURN_S = 0.1  # after a silence of the same server: meanwhile the hand runs ahead


class Part(NamedTuple):
    """State of the limits of the force, or of the torque."""

    brake: HandBrake
    gain: float = 0.0  # what is let through of it
    push: float = 1.0  # and of what pushes, while only damping is


class Limits(NamedTuple):
    """State of the limits."""

    f: Vector  # as applied last [N]
    before: Vector  # as applied when another server came, or the loop stood still [N]
    parts: tuple[Part, ...]
    silence_s: float  # from which on the server counts as silent
    left: float = 0.0  # what is let through of the force before
    ready: bool = False  # the force has been let through in full
    damped: bool = False  # in the tick before
    returns: bool = False  # rises after a silence of the same server
    quiet: bool = False  # the tick before saw a silence and nothing else
    sensed: bool = False  # the device ever was
    missing_s: float = 0.0  # for how long it has not been
    fault: int = NONE  # it ran away, or was lost
    events: int = 0  # disturbances that began, and stretches of too large a force or change
    disturbed: bool = False  # in the tick before: by damping, a fault or what is not finite
    limited: bool = False
    cause: int = WAITING  # of the state in the last tick


class LimitsParams(NamedTuple):
    """The limits."""

    max_force: float  # [N]
    slew: float  # [N] per tick
    damper_velocity: float  # [m/s]
    fault_velocity: float  # [m/s]
    timeout_s: float  # at least three packets
    release_s: float
    soft_start_s: float
    tick_s: float
    brakes: bool
    brake_stiffness: float  # [N/m]
    # force, and of six axes torque: 1 for each of its axes else 0, and its share of force and slew
    groups: tuple[tuple[Vector, float], ...]


def limits_restart(s: Limits) -> Limits:
    """Let the force start from zero again: what it comes from is not what it came from."""
    s = s._replace(before=s.f, left=1.0, returns=False, quiet=False, cause=WAITING)
    return s._replace(parts=each(_restarted, (s.parts,)))


def _restarted(s: Part) -> Part:
    return Part(loose_brake(zero(s.brake.z)), 0.0, s.push)


def limits(
    s: Limits, f: Vector, x: Vector, before: Vector, xd: Vector, silence_s: float, coupled: bool,
    sensed: bool, interrupted: bool, unreceived: bool, outside: bool, p: LimitsParams,
) -> tuple[Limits, Vector]:  # fmt: skip
    """Return the force for the device [N] in the place of the one asked for. ``before``: where the
    device was; ``coupled``: the server has answered; ``sensed``: the device knows its motion;
    ``interrupted``: no waves come, here or at the server; ``unreceived``: the server has had none
    of this user for too long.
    """
    good, speed = measured(f) and measured(x) and measured(xd), 0.0
    if not good:
        f, xd = zero(f), zero(xd)
    for i in range(len(p.groups)):
        along = times(xd, p.groups[i][0])
        speed = max(speed, dot(along, along))
    active = coupled and sensed
    ever, missing_s = s.sensed or sensed, 0.0 if sensed else s.missing_s + p.tick_s
    lost = coupled and missing_s > LOST_S
    gone = coupled and not sensed and (ever or lost)
    overdue = silence_s > p.release_s
    silent = active and silence_s > s.silence_s and (interrupted or overdue or not p.brakes)
    fast = active and speed > p.damper_velocity**2
    runs_away = active and speed > p.fault_velocity**2
    fault = s.fault or (RUNAWAY if runs_away else DEVICE_LOST if lost and ever else NONE)
    outside = active and outside
    damped, released = silent or fast or outside, silent and overdue
    force = active and good and fault == NONE
    recovers, quiet = s.damped and not damped, s.quiet and s.ready
    returns = (quiet if recovers else s.returns) and force
    rise_s = min(p.soft_start_s, RETURN_S) if returns else p.soft_start_s
    change = -p.tick_s / LET_GO_S if released else p.tick_s / rise_s
    fades = recovers and not (quiet and p.brakes)
    left = max(s.left - p.tick_s / FADE_S, 0.0) if force and not fast else 0.0
    now = Situation(interrupted, active, force, silent, outside, fades, change, left)
    given = each(_part, (s.parts, p.groups), s, f, minus(x, before), xd, now, p)
    parts, forces, longer, rising, held = columns(given)
    for i in range(len(forces)):
        f = plus(f, forces[i]) if i > 0 else forces[i]
    ready = s.ready or not (True in rising or damped)
    disturbed = gone or (active and (damped or unreceived or not force))
    limited = True in longer and force and not damped
    events = s.events + (disturbed and not s.disturbed) + (limited and not s.limited)
    cause = (  # the first of these that there is
        fault if fault != NONE else DEVICE_LOST if lost else DEVICE_SILENT if gone else
        WAITING if not active else NOT_FINITE if not good else
        RELEASED if released else SILENT if silent else
        OUTSIDE if outside else TOO_FAST if fast else
        UNRECEIVED if unreceived else SOFT_START if True in rising else
        LATE if True in held else NONE
    )  # fmt: skip
    quiet = silent and good and not (fast or outside)
    s = Limits(
        f, s.before, parts, s.silence_s, left, ready, damped, returns, quiet, ever, missing_s,
        fault, events, disturbed, limited, cause,
    )  # fmt: skip
    return s, f


class Situation(NamedTuple):
    """What a tick finds, for all parts alike."""

    waits: bool  # no waves come
    active: bool  # server and device are there
    force: bool  # there may be one
    silent: bool  # the server is
    outside: bool  # the device is beyond its workspace
    fades: bool  # a force that comes back begins with what is left of what pushes
    change: float  # of what is let through
    left: float  # what is let through of the force before


def _part(
    s: Part, group: tuple[Vector, float], of_all: Limits, f: Vector, moved: Vector, xd: Vector,
    now: Situation, p: LimitsParams,
) -> tuple[Part, Vector, bool, bool, bool]:  # fmt: skip
    """Return force or torque; whether it, or its step, was too large, whether it rises, and is
    braked. When too fast, what pushes goes at once. With a brake, which holds the hand meanwhile,
    a force comes back whole from a silence.
    """
    axes, share = group
    f, xd, last = times(f, axes), times(xd, axes), times(of_all.f, axes)
    speed, most, slew = dot(xd, xd), p.max_force * share, p.slew * share
    fast = now.active and speed > p.damper_velocity**2
    beyond, push, brake = fast or now.outside, 1.0, s.brake
    gain = s.gain * s.push if now.fades else s.gain
    gain = min(max(gain + now.change, 0.0), 1.0) if now.force else 0.0
    if now.silent or beyond:
        push = 0.0 if fast else max(s.push - p.tick_s / FADE_S, 0.0)
    if beyond or (now.silent and not p.brakes):  # what opposes the motion, and what is left
        power = dot(f, xd)
        kept = scaled(xd, power / speed) if power > 0.0 and speed > 0.0 else zero(f)
        f = plus(kept, scaled(minus(f, kept), push))
    if p.brakes:
        way, k = times(moved, axes), p.brake_stiffness
        brake, more = hand_braked(brake, now.waits, way, last, f, p.tick_s, k)
        f = f if beyond else plus(f, more)
    f = scaled(f, gain * (1.0 - now.left))
    f = plus(f, scaled(times(of_all.before, axes), now.left))
    applied, longer = shortened(f, most), dot(f, f) > most**2
    step = minus(applied, last)
    if dot(step, step) > slew**2:
        applied, longer = plus(last, shortened(step, slew)), True
    return Part(brake, gain, push), applied, longer, gain < 1.0, brake_limit(brake.largest) > 0.0
