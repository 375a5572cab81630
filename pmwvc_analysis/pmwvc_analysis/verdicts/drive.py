# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Who drives a motion, the loop or the hands, and which oscillation a loop keeps up.

While a force F_k is held a device goes from x_k to x_{k+1}, and its loop gives it the work
-F_k . (x_{k+1} - x_k). In motion beyond half a hertz, a passive loop takes more from all devices
together than it gives; once it may give back what masses and springs hold. One that keeps a
motion up gives, cycle after cycle, what the hands take out of it.

A loop that keeps an oscillation up is told from late packets that set one off again and again: one
that is kept up has one frequency all the time, and goes on while packets come in time; one that is
set off dies out there until the next late packet.

Equations: docs/theory.md 13.13.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.felt import REST_BAND_HZ
from pmwvc_analysis.verdicts.oscillation import (
    FADED,
    HALVED,
    Motion,
    Strength,
    beyond,
    shaking,
)
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces
from pmwvc_core.words import quantity

DRIVES = 0.1  # share of the work from which on one side drives a motion
CYCLES = 4  # a loop gives so many times what masses and springs hold; a passive one: 2.3 once
NEAR, MOSTLY = 0.1, 0.6  # of a frequency; of a motion's power within that
IN_A_THIRD = 4  # cycles, by which one frequency is told from a few jolts
MOST = 0.7  # of it, where packets are late so often that nothing shows whether it goes on
PERIODS = 3  # in time, of a stretch that tells: the loop answers in the first


class Drive(NamedTuple):
    """Work that the loop gave to all devices together in motion beyond half a hertz."""

    given_j: float
    share: float  # of the work that went to and fro, -1..1
    held_j: float  # most that masses and springs held of it
    free: bool  # whether a hand moves as it likes: a person, or a motion or force that is given
    made_j: float = 0.0  # what came out between hands and object and did not go in

    @property
    def by_loop(self) -> bool:
        """Tell whether the loop drove the motion."""
        return self.share > DRIVES and self.given_j > CYCLES * self.held_j

    @property
    def by_hands(self) -> bool:
        """Tell whether hands did that move as they like."""
        return self.thrown and self.share < -DRIVES

    @property
    def thrown(self) -> bool:
        """Tell whether such hands gave more than they got."""
        return self.free and self.given_j < 0.0 and self.made_j <= self.given_j / self.share


UNKNOWN = Drive(0.0, 0.0, 0.0, False)


class LoopWork(NamedTuple):
    """What the loop gave to a device in motion beyond half a hertz, tick by tick [J], with the
    parts of force [N] and position [m] beyond it, ``(tick, dof)``.
    """

    user: UserTraces
    mass: float
    force: Array
    x: Array
    given_j: Array


def works(traces: SessionTraces, scenario: Scenario | None) -> list[LoopWork]:
    """Return the work on every device of a session; none where the environment has energy of its
    own, or a user of the scenario was not recorded.
    """
    if scenario is None or scenario.environment.own_energy(scenario.server):
        return []
    known, found = {user.name: user for user in scenario.users}, []
    for user in traces.users:
        finite = np.isfinite(user.x_m).all() and np.isfinite(user.f_applied).all()
        if user.name not in known or not finite:
            return []
        force, x = (beyond(a, user.tick_s, REST_BAND_HZ) for a in (user.f_applied, user.x_m))
        given_j = -np.sum(force * np.diff(x, axis=0, append=x[-1:]), axis=-1)
        found.append(LoopWork(user, known[user.name].device.mass, force, x, given_j))
    return found if len(found) >= len(known) else []


def drive(
    traces: SessionTraces,
    scenario: Scenario | None,
    start_s: float,
    end_s: float,
    done: Sequence[LoopWork] | None = None,
) -> Drive:
    """Return who drove the motion between two instants [s]; ``UNKNOWN`` where no :func:`works`
    are known (``done``, if they were asked for already), or ticks were not recorded.
    """
    given_j = moved_j = held_j = 0.0
    for user, mass, force, x, work_j in works(traces, scenario) if done is None else done:
        inside = (user.time_s >= start_s) & (user.time_s <= end_s)
        whole = round((end_s - max(start_s, float(user.time_s[0]))) / user.tick_s) - 2
        if inside.sum() < max(whole, 2):
            return UNKNOWN
        given_j += float(work_j[inside].sum())
        moved_j += float(np.abs(work_j[inside]).sum())
        held_j += 0.5 * mass * _longest(user.xd_m[inside]) ** 2
        held_j += 0.5 * _longest(force[inside]) * _longest(x[inside])  # of a spring in between
    if scenario is None or not moved_j > 0.0:
        return UNKNOWN
    if (server := traces.server) is not None:
        inside = (server.time_s >= start_s) & (server.time_s <= end_s)
        held_j += 0.5 * scenario.server.object_mass * _longest(server.xd_o[inside]) ** 2
    free = any(u.operator.is_free or not u.device.is_simulated for u in scenario.users)
    found = Drive(given_j, given_j / moved_j, held_j, free)
    if not found.thrown:
        return found
    joint = [each.joint for each in user_energies(traces, scenario)]
    spans = [e.balance_j[(e.time_s >= start_s) & (e.time_s <= end_s)] for e in joint]
    return found._replace(made_j=sum(float(span[0] - span[-1]) for span in spans if len(span)))


def kept_driven(traces: SessionTraces, scenario: Scenario | None, moved: Sequence[Motion]) -> str:
    """Return which motion the loop drove at any time of a session, in words; empty: none."""
    done = works(traces, scenario)
    for motion in (replace(each, band_hz=REST_BAND_HZ) for each in moved if done):
        for start_s, end_s in shaking(motion):
            found = drive(traces, scenario, start_s, end_s, done)
            if found.by_loop:
                during = f"from {start_s:.2f} to {end_s:.2f} s"
                given = f"the loop gave the hands {quantity(found.given_j, 'J')} in the meantime"
                return f"{motion.name} oscillated {during}, and {given}"
    return ""


def _longest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))


def kept_up(
    found: Strength,
    motion: Motion,
    duration_s: float,
    timely: Sequence[tuple[float, float]],
) -> bool:
    """Tell whether a motion beyond the band is one that a loop keeps up: most of it within a tenth
    of one frequency in each third of the judged span, ``IN_A_THIRD`` periods at least, no less
    than half as strong in the middle one as in the first, and no weaker by a tenth at the end of
    the ``timely`` stretches, from and until [s], in which packets come in time.
    """
    inside = motion.time_s >= max(0.5 * duration_s, motion.since_s)
    fast = beyond(motion.velocity, motion.period_s, motion.band_hz)[inside]
    if found.midway <= HALVED or len(fast) < 3 or not np.isfinite(fast).all() or not fast.any():
        return False
    whole = power_of(fast)
    strongest = int(np.argmax(whole))
    if strongest < 3 * IN_A_THIRD:
        return False
    thirds = [(power_of(third), strongest / 3.0) for third in np.array_split(fast, 3)]
    near = _near(whole, float(strongest))
    if min(near, *(_near(power, at) for power, at in thirds)) < MOSTLY:
        return False
    squares, time_s = np.sum(fast * fast, axis=-1), motion.time_s[inside]
    left = _left(squares, time_s, len(fast) * motion.period_s / strongest, timely)
    return near >= MOST if left is None else left >= FADED


def power_of(velocity: Array) -> Array:
    """Return the power spectrum of a velocity ``(ticks, dof)``, all axes together."""
    window = np.hanning(len(velocity)).reshape(-1, *[1] * (velocity.ndim - 1))
    found: Array = np.sum(np.abs(np.fft.rfft(velocity * window, axis=0)) ** 2, axis=-1)
    return found


def _near(power: Array, at: float) -> float:
    """Return how much of a power spectrum is near one of its bins."""
    bins = max(round(NEAR * at), 2)
    first = max(round(at) - bins, 0)
    total = float(power.sum())
    return float(power[first : round(at) + bins + 1].sum()) / total if total > 0.0 else 0.0


def _left(
    squares: Array, time_s: Array, strongest_s: float, timely: Sequence[tuple[float, float]]
) -> float | None:
    """Return the strength in the last period [s] of timely stretches over that in the second."""
    early, late = 0.0, 0.0
    for from_s, until_s in timely:
        periods = math.floor((until_s - from_s) / strongest_s)
        if periods < PERIODS:
            continue
        begins_s = (from_s + strongest_s, from_s + (periods - 1) * strongest_s)
        means = [squares[(time_s >= at) & (time_s < at + strongest_s)] for at in begins_s]
        if min(map(len, means)):
            early, late = early + float(means[0].mean()), late + float(means[1].mean())
    return math.sqrt(late / early) if early > 0.0 else None
