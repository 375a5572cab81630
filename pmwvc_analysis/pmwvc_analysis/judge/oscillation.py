# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How strong the motion is that nobody makes on purpose.

What is made on purpose: everything below ``band_hz`` of the operator, in which hands move on
purpose (for a target that rests, below half a hertz), and what an environment of the library is
driven with. A hand that moves in steps, an object let go or contact made for the first time give
short bursts of fast motion; a median over quarter-second windows passes over them.

Where rows are missing, or the loop did not run, the motion is not known: it is filtered piece by
piece, and where less than half of the windows of the end or the middle are known, nothing is told.

Not known: what drives an environment of somebody else's. Its motion counts as the loop's.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import OperatorParams, ServerParams
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.traces import SessionTraces

WINDOW_S = 0.25
PAUSE_S, PAUSE_PERIODS = 0.02, 2.5
DEFAULT_BAND_HZ = 8.0
REST_BAND_HZ = 0.5
HARMONICS = 3.5  # of a sinusoid that makes and breaks contact


@dataclass(frozen=True)
class Motion:
    """A velocity to be judged, ``(row, dof)`` [m/s], and what in it is on purpose or noise."""

    name: str
    time_s: Array
    period_s: float
    velocity: Array
    band_hz: float
    noise_m_s: float = 0.0


@dataclass(frozen=True)
class Strength:
    """Median RMS velocity of the last third [m/s]; the last sixth over that in the middle.

    ``known`` tells whether enough of both was recorded.
    """

    late_m_s: float
    growth: float
    known: bool = True


def strength(motion: Motion, duration_s: float) -> Strength:
    """Return how strong motion beyond the band is, and whether it grows or dies out."""
    windows = max(1, round(WINDOW_S / motion.period_s))
    pieces = _pieces(motion)
    if len(motion.velocity) // windows < 6 or not np.isfinite(motion.velocity).all():
        return Strength(0.0, 0.0, known=len(pieces) <= 1)
    found = [_levels(motion, piece, windows) for piece in pieces]
    middles, levels = (np.concatenate(each) for each in zip(*found, strict=True))

    def rows(start: float, end: float) -> Array:
        found: Array = levels[(middles >= start * duration_s) & (middles < end * duration_s)]
        return found

    def median(start: float, end: float) -> float:
        own = rows(start, end)
        return float(np.median(own)) if len(own) else 0.0

    expected = 0.5 * duration_s / 6.0 / (windows * motion.period_s) - 1.0
    known = min(len(rows(3 / 6, 4 / 6)), len(rows(4 / 6, 5 / 6)), len(rows(5 / 6, 1.01)))
    late, middle = median(5 / 6, 1.01), median(3 / 6, 4 / 6)
    return Strength(
        min(late, median(4 / 6, 1.01)),
        late / middle if middle > 0.0 else math.inf,
        known=len(pieces) <= 1 or known >= expected,
    )


def _pieces(motion: Motion) -> list[slice]:
    """Return the rows between pauses that are too long to filter across."""
    pauses = np.diff(motion.time_s) > max(PAUSE_S, PAUSE_PERIODS * motion.period_s)
    edges = [0, *(np.flatnonzero(pauses) + 1).tolist(), len(motion.time_s)]
    return [slice(start, end) for start, end in itertools.pairwise(edges) if end > start]


def _levels(motion: Motion, piece: slice, windows: int) -> tuple[Array, Array]:
    """Return middle [s] and RMS velocity beyond the band [m/s] of every whole window."""
    velocity = motion.velocity[piece]
    count = len(velocity) // windows
    fast = beyond(velocity, motion.period_s, motion.band_hz)
    squares = np.sum(fast * fast, axis=-1)[: count * windows].reshape(count, windows)
    times = motion.time_s[piece][: count * windows].reshape(count, windows)
    return times.mean(axis=1), np.sqrt(squares.mean(axis=1))


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
        return max(REST_BAND_HZ, HARMONICS * operator.frequency_hz)
    if operator.kind == "chirp":
        return 1.5 * max(operator.frequency_hz, operator.frequency_end_hz)
    if operator.kind.startswith("playback"):
        return 10.0
    return REST_BAND_HZ


def environment_band_hz(server: ServerParams) -> float:
    """Return the frequency below which the environment moves by itself, 0 where it does not."""
    driven = server.environment == "active_wall" and server.active_wall.amplitude_m > 0.0
    return HARMONICS * server.active_wall.frequency_hz if driven else 0.0


def _bands(scenario: Scenario | None, names: list[str]) -> dict[str, float]:
    """Return each user's band; all move with the fastest hand and with the environment."""
    if scenario is None:
        return dict.fromkeys(names, DEFAULT_BAND_HZ)
    moves = scenario.task.kind == "carry"
    rise = scenario.task.move_rise_s
    band = max(operator_band_hz(user.operator, rise, moves=moves) for user in scenario.users)
    return dict.fromkeys(names, max(band, environment_band_hz(scenario.server)))


def motions(traces: SessionTraces, scenario: Scenario | None) -> list[Motion]:
    """Return what is judged of a session: the motion of every device and of the object."""
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
