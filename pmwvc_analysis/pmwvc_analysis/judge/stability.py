# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Was the session stable? Judged from the motion itself, not from a model.

In this order:

``diverged``
    a signal is not finite, or a device, avatar or the object is more than half the workspace
    outside of it, or the oscillation (below) grows: at least twice as strong at the end as in the
    middle, and beyond 50 mm/s.
``limited by safety``
    a safety layer reached its fault state, or shortened the force of a coupled device again and
    again: in more than a twentieth of the second half of the session, in three or more separate
    events.
``sustained oscillation``
    motion faster than the person's own that does not die out: its RMS velocity is beyond 1 mm/s in
    most of the last third of the session, and it does not halve from the middle of the session to
    its end.

What is the person's own: everything below ``band_hz`` of the operator, in which hands move on
purpose (for a target that rests, below half a hertz). A hand that moves in steps, an object let go
or contact made for the first time give short bursts of fast motion; a median over quarter-second
windows passes over them.
"""

import math
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import OperatorParams
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.traces import SessionTraces, UserTraces

OSCILLATION_M_S = 1e-3
GROWN_M_S = 50e-3
WINDOW_S = 0.25
DEFAULT_WORKSPACE_M = 0.2
DEFAULT_BAND_HZ = 8.0
REST_BAND_HZ = 0.5
COUPLED, FAULT = 1, 3


@dataclass(frozen=True)
class Verdict:
    """Stable or the kind of instability, what showed it, the strongest late oscillation [m/s]."""

    instability: str | None
    why: str
    oscillation_m_s: float

    @property
    def stable(self) -> bool:
        """Tell whether no instability was found."""
        return self.instability is None


@dataclass(frozen=True)
class Motion:
    """A velocity to be judged, ``(row, dof)`` [m/s], and what in it is on purpose or noise."""

    name: str
    time_s: Array
    period_s: float
    velocity: Array
    band_hz: float
    noise_m_s: float = 0.0


def verdict(traces: SessionTraces, scenario: Scenario | None) -> Verdict:
    """Judge one session."""
    outside = _outside(traces, scenario)
    motions = _motions(traces, scenario)
    strengths = [(strength(motion, traces.duration_s), motion) for motion in motions]
    strongest = max((s.late_m_s for s, _ in strengths), default=0.0)
    if outside:
        return Verdict("diverged", outside, strongest)
    for found, motion in strengths:
        if found.late_m_s > GROWN_M_S and found.growth >= 2.0:
            why = f"{motion.name} oscillates with {found.late_m_s * 1e3:.0f} mm/s and growing"
            return Verdict("diverged", why, strongest)
    limited = _limited(traces)
    if limited:
        return Verdict("limited by safety", limited, strongest)
    for found, motion in strengths:
        if found.late_m_s > max(OSCILLATION_M_S, motion.noise_m_s) and found.growth > 0.5:
            why = f"{motion.name} keeps oscillating with {found.late_m_s * 1e3:.1f} mm/s"
            return Verdict("sustained oscillation", why, strongest)
    return Verdict(None, "motion beyond the person's own dies out", strongest)


@dataclass(frozen=True)
class Strength:
    """Median RMS velocity of the last third [m/s]; the last sixth over that in the middle."""

    late_m_s: float
    growth: float


def strength(motion: Motion, duration_s: float) -> Strength:
    """Return how strong motion beyond the person's own is, and whether it grows or dies out."""
    windows = max(1, round(WINDOW_S / motion.period_s))
    count = len(motion.velocity) // windows
    if count < 6 or not np.isfinite(motion.velocity).all():
        return Strength(0.0, 0.0)
    fast = beyond(motion.velocity, motion.period_s, motion.band_hz)
    squares = np.sum(fast * fast, axis=-1)[: count * windows].reshape(count, windows)
    levels = np.sqrt(squares.mean(axis=1))
    middles = motion.time_s[: count * windows].reshape(count, windows).mean(axis=1)

    def median(start: float, end: float) -> float:
        rows = levels[(middles >= start * duration_s) & (middles < end * duration_s)]
        return float(np.median(rows)) if len(rows) else 0.0

    late, middle = median(5 / 6, 1.01), median(3 / 6, 4 / 6)
    return Strength(min(late, median(4 / 6, 1.01)), late / middle if middle > 0.0 else math.inf)


def beyond(velocity: Array, period_s: float, band_hz: float) -> Array:
    """Return the part of a velocity above a frequency, filtered both ways: no delay."""
    from scipy import signal

    if band_hz * period_s >= 0.45 or len(velocity) < 30:
        return np.zeros_like(velocity)
    sos = signal.butter(4, band_hz, "highpass", fs=1.0 / period_s, output="sos")
    pad = min(len(velocity) - 1, round(3.0 / (band_hz * period_s)))
    result: Array = signal.sosfiltfilt(sos, velocity, axis=0, padtype="odd", padlen=pad)
    return result


def operator_band_hz(operator: OperatorParams, move_rise_s: float, *, moves: bool) -> float:
    """Return the frequency below which this operator moves on purpose.

    A minimum-jerk move of duration D has next to nothing above 6/D. A sinusoid brings harmonics
    where contact is made and broken. A recorded person moves and trembles up to 10 Hz.
    """
    if operator.kind == "hand":
        return max(2.0, 6.0 / move_rise_s) if moves else REST_BAND_HZ
    if operator.kind == "sinusoid":
        return max(REST_BAND_HZ, 3.5 * operator.frequency_hz)
    if operator.kind == "chirp":
        return 1.5 * max(operator.frequency_hz, operator.frequency_end_hz)
    if operator.kind.startswith("playback"):
        return 10.0
    return REST_BAND_HZ


def _bands(scenario: Scenario | None, names: list[str]) -> dict[str, float]:
    """Return each user's band; the object and the others move with the fastest hand."""
    if scenario is None:
        return dict.fromkeys(names, DEFAULT_BAND_HZ)
    moves = scenario.task.kind == "carry"
    rise = scenario.task.move_rise_s
    band = max(operator_band_hz(user.operator, rise, moves=moves) for user in scenario.users)
    return dict.fromkeys(names, band)


def _motions(traces: SessionTraces, scenario: Scenario | None) -> list[Motion]:
    names = [user.name for user in traces.users]
    server = traces.server
    bands = _bands(scenario, names + (server.users if server else []) + ["object"])
    known = {user.name: user for user in scenario.users} if scenario else {}
    found = [
        Motion(
            f"{user.name}'s device",
            user.time_s,
            user.tick_s,
            user.xd_m,
            bands[user.name],
            _noise(known.get(user.name)),
        )
        for user in traces.users
    ]
    if server is not None:
        found.append(
            Motion("the object", server.time_s, server.period_s, server.xd_o, bands["object"])
        )
    return found


def _noise(user: User | None) -> float:
    """Return twice the RMS of the velocity that an encoder's steps alone make [m/s].

    The difference of two positions, each uniform within a step q, over one tick: q / (tick sqrt
    6).
    """
    if user is None or user.device.velocity != "euler":
        return 0.0
    return 2.0 * user.device.encoder_step_m / (user.master.tick_s * math.sqrt(6.0))


def _outside(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return what is not finite or far outside the workspace, in words; empty when nothing is."""
    workspace = DEFAULT_WORKSPACE_M
    if scenario is not None:
        workspace = max(user.device.workspace_m for user in scenario.users)
    positions = [(f"{user.name}'s device", user.x_m, user.time_s) for user in traces.users]
    if traces.server is not None:
        server = traces.server
        positions.append(("the object", server.x_o, server.time_s))
        for name, x_s, state in zip(server.users, server.x_s, server.state, strict=True):
            present = state > 0
            positions.append((f"{name}'s avatar", x_s[present], server.time_s[present]))
    for name, x, time_s in positions:
        if not np.isfinite(x).all():
            return f"{name}: a position is not a number"
        far = np.flatnonzero(np.abs(x).max(axis=-1, initial=0.0) > 1.5 * workspace)
        if len(far):
            return (
                f"{name} left the workspace (+-{workspace * 1e3:.0f} mm) at {time_s[far[0]]:.2f} s"
            )
    return ""


def _limited(traces: SessionTraces) -> str:
    """Return which safety layer took over, in words; empty when none did."""
    for user in traces.users:
        faults = np.flatnonzero(user.state == FAULT)
        if len(faults):
            reason = user.reason[faults[0]] or "no reason given"
            return f"{user.name}: safety fault at {user.block_time_s[faults[0]]:.2f} s ({reason})"
        share, events = _shortened(user, traces.duration_s)
        if share > 0.05 and events >= 3:
            return (
                f"{user.name}: the force was limited {events} times, "
                f"{share:.0%} of the second half"
            )
    return ""


def _shortened(user: UserTraces, duration_s: float) -> tuple[float, int]:
    """Return in which share of the second half the force was limited, and how often anew."""
    asked, applied = (
        np.linalg.norm(user.f_m, axis=-1),
        np.linalg.norm(user.f_m - user.f_applied, axis=-1),
    )
    block = np.clip(
        np.searchsorted(user.block_time_s, user.time_s, side="right"), 0, len(user.state) - 1
    )
    half = (user.time_s > duration_s / 2) & (user.state[block] == COUPLED)
    limited = (applied > 0.01 * asked + 1e-3) & half
    if not half.any():
        return 0.0, 0
    return float(limited.sum() / half.sum()), int(
        (np.diff(limited.astype(int)) > 0).sum() + limited[0]
    )
