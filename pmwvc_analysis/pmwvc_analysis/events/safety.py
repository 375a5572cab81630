# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Events of the safety limits of one device: damping, release, fault, limited force."""

from collections.abc import Iterator

import numpy as np

from pmwvc_analysis.events.event import Event, event
from pmwvc_analysis.traces.reductions import runs
from pmwvc_core.master.safety import BRAKING, SafetyState
from pmwvc_core.numeric import Flags
from pmwvc_core.plural import count
from pmwvc_core.traces import UserTraces

STARTING, COUPLED, DAMPING, FAULT = SafetyState
RELEASED = "released"  # in the reason, once damping itself has been released
LIMITED_N = 1e-3  # a force that differs by this much and
LIMITED_RATIO = 0.01  # by this ratio was limited
JOIN_S = 0.25
MOST = 20  # events of one kind; more are reported as one


def of_user(user: UserTraces) -> Iterator[Event]:
    """Yield every change of state and every stretch of limited force of one device."""
    yield from _states(user)
    yield from _limits(user)


def _states(user: UserTraces) -> Iterator[Event]:
    who, coupled, lost = f"{user.name} master", False, False
    before: tuple[int, str] | None = None
    for row, now in enumerate(zip(user.state.tolist(), user.reason, strict=True)):
        if now == before:
            continue
        before, (state, reason) = now, now
        time_s = float(user.block_time_s[row])
        if state == COUPLED:
            if lost:
                yield event(time_s, who, "damping", "force restored in full")
            coupled, lost = True, False
        elif state == FAULT:
            lost = True
            yield event(time_s, who, "release", f"safety fault: {reason}")
        elif state == DAMPING:
            lost = True
            kind = "release" if RELEASED in reason else "damping"
            yield event(time_s, who, kind, f"safety limits: {reason or 'damping only'}")
        elif coupled and not lost:
            lost = True
            yield event(time_s, who, "damping", f"force ramps up from zero: {reason}")


def _limits(user: UserTraces) -> Iterator[Event]:
    flags = limited(user)
    found = runs(flags, user.time_s, join_s=JOIN_S)
    who = f"{user.name} master"
    for first, last in found[:MOST]:
        rows = slice(first, last + 1)
        asked = float(np.linalg.norm(user.f_m[rows], axis=-1).max())
        applied = float(np.linalg.norm(user.f_applied[rows], axis=-1).max())
        length = float(user.time_s[last] - user.time_s[first] + user.tick_s)
        what = (
            f"force limited for {length:.3f} s: up to {asked:.2f} N commanded, "
            f"{applied:.2f} N applied"
        )
        yield event(float(user.time_s[first]), who, "limit", what)
    if len(found) > MOST:
        first, last = found[MOST][0], found[-1][1]
        times = count(len(found) - MOST, "more time")
        what = (
            f"force limited {times} until {user.time_s[last]:.2f} s, "
            f"{float(flags.sum()) * user.tick_s:.2f} s in all"
        )
        yield event(float(user.time_s[first]), who, "limit", what)


def limited(user: UserTraces) -> Flags:
    """Tell in which ticks the force of a coupled device was limited."""
    with np.errstate(invalid="ignore", over="ignore"):
        asked = np.linalg.norm(user.f_m, axis=-1)
        off = np.linalg.norm(user.f_m - user.f_applied, axis=-1)
    return np.asarray(unbraked(user) & (off > LIMITED_RATIO * asked + LIMITED_N))


def unbraked(user: UserTraces) -> Flags:
    """Tell in which ticks a coupled device was to have the controller's force and no more: where
    it brakes it has more, which no limit made.
    """
    block = np.searchsorted(user.block_time_s, user.time_s + 0.5 * user.tick_s)
    block = np.clip(block, 0, len(user.state) - 1)
    whole = (user.state == COUPLED) & ~brakes(user)
    return np.asarray(whole[block] & whole[np.maximum(block - 1, 0)])


def brakes(user: UserTraces) -> Flags:
    """Tell in which blocks the brake of a coupled device acts, because waves came late."""
    return np.array([reason == BRAKING for reason in user.reason], dtype=bool)
