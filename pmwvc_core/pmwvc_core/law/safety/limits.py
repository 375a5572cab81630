# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What reaches the device, for whatever a controller asks, including values that are not numbers.
Research software: not a certified safeguard.

* the force starts at zero, changes by at most ``max_slew * tick_s`` in a tick and is never longer
  than ``max_force`` (a vector keeps its direction); of six axes force and torque each by itself;
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

On the strict channel a brake holds the hand (:mod:`.brakes`). Equations: docs/theory.md 10.2.
"""

from typing import NamedTuple

from pmwvc_core.law.safety.brakes import HandBrake, brake_limit, brake_push, holding, loose_brake
from pmwvc_core.law.vectors import Vector, dot, minus, plus, scaled, shortened, times, within, zero

LOST_S = 1.0
# Causes of the state of the limits:
NONE, WAITING, SOFT_START, SILENT, RELEASED, TOO_FAST, NOT_FINITE, RUNAWAY = range(8)
OUTSIDE, DEVICE_SILENT, DEVICE_LOST, UNRECEIVED, LATE = range(8, 13)
FADE_S, LET_GO_S = 0.02, 0.5
RETURN_S = 0.1  # after a silence of the same server: meanwhile the hand runs ahead
LARGEST = 1e100  # of a measurement or a force; what is beyond it is none


class Limits(NamedTuple):
    """State of the limits."""

    f: Vector  # as applied last [N]
    before: Vector  # as applied when another server came, or the loop stood still [N]
    brake: HandBrake
    silence_s: float  # from which on the server counts as silent
    gain: float = 0.0  # what is let through of the whole force
    left: float = 0.0  # and of the one before
    push: float = 1.0  # and of what pushes, while only damping is
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
    brake = loose_brake(zero(s.f))._replace(x=s.brake.x)
    s = s._replace(before=s.f, left=1.0, gain=0.0, returns=False, quiet=False)
    return s._replace(brake=brake, cause=WAITING)


def limits(
    s: Limits, f: Vector, x: Vector, xd: Vector, silence_s: float, coupled: bool, sensed: bool,
    interrupted: bool, unreceived: bool, outside: bool, p: LimitsParams,
) -> tuple[Limits, Vector]:  # fmt: skip
    """Return the force for the device [N] in the place of the one asked for. ``coupled``: the
    server has answered; ``sensed``: the device knows its motion; ``interrupted``: no waves come,
    here or at the server; ``unreceived``: the server has had none of this user for too long.
    """
    brake, holds = s.brake, False
    if p.brakes:
        brake, holds = holding(brake, interrupted, x, s.f, p.tick_s, p.brake_stiffness)
    good = within(f, LARGEST) and within(x, LARGEST) and within(xd, LARGEST)
    if not good:
        f, xd = zero(f), zero(xd)
    speed, active = dot(xd, xd), coupled and sensed
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
    gain, push, returns = _faded(s, force, damped, fast, released, p)
    ready = s.ready or (gain >= 1.0 and not damped)
    if fast or outside or (silent and not p.brakes):  # what opposes the motion, and what is left
        power = dot(f, xd)
        kept = scaled(xd, power / speed) if power > 0.0 and speed > 0.0 else zero(f)
        f = plus(kept, scaled(minus(f, kept), push))
    if holds:
        brake, more = brake_push(brake, f, p.brake_stiffness)
        f = f if fast or outside else plus(f, more)
    left = max(s.left - p.tick_s / FADE_S, 0.0) if force and not fast else 0.0
    f = plus(scaled(f, gain * (1.0 - left)), scaled(s.before, left))
    applied, limited = _capped(f, p.max_force, p)
    change, sudden = _capped(minus(applied, s.f), p.slew, p)
    if sudden:
        applied, limited = plus(s.f, change), True
    unreceived = unreceived and active
    disturbed = gone or (active and (damped or unreceived or not force))
    limited = limited and force and not damped
    events = s.events + (disturbed and not s.disturbed) + (limited and not s.limited)
    cause = (  # the first of these that there is
        fault if fault != NONE else DEVICE_LOST if lost else DEVICE_SILENT if gone else
        WAITING if not active else NOT_FINITE if not good else
        RELEASED if released else SILENT if silent else
        OUTSIDE if outside else TOO_FAST if fast else
        UNRECEIVED if unreceived else SOFT_START if gain < 1.0 else
        LATE if holds and brake_limit(brake.largest) > 0.0 else NONE
    )  # fmt: skip
    quiet = silent and good and not (fast or outside)
    s = Limits(
        applied, s.before, brake, s.silence_s, gain, left, push, ready, damped, returns, quiet,
        ever, missing_s, fault, events, disturbed, limited, cause,
    )  # fmt: skip
    return s, applied


def _capped(f: Vector, most: float, p: LimitsParams) -> tuple[Vector, bool]:
    """Return force and torque, each at most so long, and whether one was longer."""
    longer = False
    for i in range(len(p.groups)):
        axes, share = p.groups[i]
        part, rest = times(f, axes), minus(f, times(f, axes))
        longer = longer or dot(part, part) > (most * share) ** 2
        f = plus(shortened(part, most * share), rest)
    return f, longer


def _faded(
    s: Limits, force: bool, damped: bool, fast: bool, released: bool, p: LimitsParams
) -> tuple[float, float, bool]:
    """Return gain and push of a tick, and whether the force returns; when too fast, what pushes
    goes at once. With a brake, which holds the hand meanwhile, the force comes back whole.
    """
    recovers, quiet, gain = s.damped and not damped, s.quiet and s.ready, s.gain
    returns = (quiet if recovers else s.returns) and force
    if recovers and not (quiet and p.brakes):
        gain *= s.push
    if released:
        gain = max(gain - p.tick_s / LET_GO_S, 0.0)
    else:
        rise_s = min(p.soft_start_s, RETURN_S) if returns else p.soft_start_s
        gain = min(gain + p.tick_s / rise_s, 1.0)
    push = 1.0
    if damped:
        push = 0.0 if fast else max(s.push - p.tick_s / FADE_S, 0.0)
    return gain if force else 0.0, push, returns
