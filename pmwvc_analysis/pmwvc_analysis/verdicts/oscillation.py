# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""RMS velocity above the band in which an operator moves voluntarily (:mod:`..traces.felt`).

A median over quarter-second windows passes over short bursts: a hand's step, a first contact.
Motion is judged from the middle of the session, or from the last contact or change of a parameter
if that is later; less than a second after it, it is unknown whether it decays. Motion is filtered
piece by piece between missing rows; where less than half of the windows is known there is no
verdict.
"""

import itertools
import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.felt import bands, closed_s, stops_s
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.traces.sums import powers, spans
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import SessionTraces, UserTraces


@dataclass(frozen=True)
class Motion:
    """A velocity to be judged, ``(row, dof)`` [m/s], and what in it is on purpose or noise."""

    name: str
    time_s: Array
    period_s: float
    velocity: Array
    band_hz: float
    noise_m_s: float = 0.0
    images: float = 0.0  # largest ratio of sampling images to purposeful motion
    since_s: float = 0.0  # of the last disturbance that is no fault of the loop [s]
    since: str = ""  # what it was


@dataclass(frozen=True)
class Strength:
    """Median RMS velocity of a motion beyond the band late in the judged span [m/s], and how it
    changed.
    """

    motion: Motion
    late_m_s: float = 0.0
    growth: float = 0.0  # last third over the first
    midway: float = 0.0  # middle third over the first
    known: bool = True  # whether enough of both was recorded
    settled: bool = True  # whether the span is long enough
    purposeful_m_s: float = 0.0  # median RMS velocity within the band
    apart_s: float = 0.0  # time from the first third to the last [s]

    @property
    def most_m_s(self) -> float:
        """The largest speed beyond the band that is no oscillation [m/s]: 1 mm/s, or what an
        encoder's noise or images of sampling make.
        """
        motion = self.motion
        return max(th.OSCILLATION_M_S, motion.noise_m_s, motion.images * self.purposeful_m_s)

    @property
    def lasts(self) -> bool:
        """Tell whether it is an oscillation that does not die out."""
        return self.late_m_s > self.most_m_s and self.growth > th.HALVED

    @property
    def fades(self) -> bool:
        """Tell whether it became less from third to third, too slowly to be seen to die out."""
        return th.HALVED < self.growth < min(self.midway, th.FADED) and self.midway < 1.0

    def decays_by(self, rate_per_s: float) -> bool:
        """Tell whether it changed as a motion that decays at a rate [1/s]; NaN: no such rate."""
        if not rate_per_s < 0.0 or self.growth <= 0.0:
            return False
        return abs(math.log(self.growth) - rate_per_s * self.apart_s) < -math.log(th.FADED)


def strength(motion: Motion, duration_s: float) -> Strength:
    """Return how strong motion beyond the band is, and whether it grows or dies out."""
    if not (found := _levels(motion)):
        return Strength(motion, known=len(_pieces(motion)) <= 1)
    middles, levels, slow = (np.concatenate(each) for each in zip(*found, strict=True))
    end_s = min(duration_s, float(motion.time_s[-1]) + motion.period_s)  # its user may have left
    start_s = min(max(0.5 * end_s, motion.since_s), max(end_s - th.SHORTEST_S, 0.0))
    third_s = (end_s - start_s) / 3.0
    edges_s = (start_s, start_s + third_s, start_s + 2.0 * third_s, math.inf)
    thirds = [(middles >= a) & (middles < b) for a, b in itertools.pairwise(edges_s)]
    last_two = middles >= edges_s[1]
    early, middle, late = (_median(levels[third]) for third in thirds)
    known = min(int(third.sum()) for third in thirds)
    return Strength(
        motion,
        min(late, _median(levels[last_two])),
        late / early if early > 0.0 else math.inf,
        middle / early if early > 0.0 else math.inf,
        known=len(found) <= 1 or known >= 0.5 * third_s / th.WINDOW_S - 1.0,
        settled=motion.since_s <= 0.5 * end_s or end_s - motion.since_s >= th.SETTLE_S,
        purposeful_m_s=_median(slow[last_two]),
        apart_s=2.0 * third_s,
    )


def shaking(motion: Motion) -> list[tuple[float, float]]:
    """Return from when to when [s] a motion beyond the band was about as strong all the time, for
    ``SHORTEST_S`` at least.
    """
    found: list[tuple[float, float]] = []
    for middles, levels, _ in _levels(motion):
        for run in _long(levels > max(th.OSCILLATION_M_S, motion.noise_m_s)):
            strong_m_s = np.sort(levels[run])[-th.LEAST_WINDOWS]
            for part in _long(levels[run] > th.HALVED * strong_m_s):
                half_s, times = th.WINDOW_S / 2, middles[run][part]
                found.append((float(times[0]) - half_s, float(times[-1]) + half_s))
    return found


def _long(flags: Flags) -> list[slice]:
    return [span for span in spans(flags) if span.stop - span.start >= th.LEAST_WINDOWS]


def _median(values: Array) -> float:
    return float(np.median(values)) if len(values) else 0.0


def _pieces(motion: Motion) -> list[Integers]:
    """Return the rows between pauses that are too long to filter across."""
    pauses = np.diff(motion.time_s) > max(th.STALL_S, th.STALL_PERIODS * motion.period_s)
    return np.split(np.arange(len(motion.time_s)), np.flatnonzero(pauses) + 1)


def _levels(motion: Motion) -> list[tuple[Array, Array, Array]]:
    """Return middle [s], RMS velocity beyond the band and within it [m/s] of every window, for
    each piece; empty where the motion is shorter than ``LEAST_WINDOWS`` windows, or no number.
    """
    rows = max(1, round(th.WINDOW_S / motion.period_s))  # of a window
    if len(motion.velocity) // rows < th.LEAST_WINDOWS or not np.isfinite(motion.velocity).all():
        return []

    def means(values: Array) -> Array:
        count = len(values) // rows
        return np.asarray(values[: count * rows].reshape(count, rows).mean(axis=1))

    found = []
    for piece in _pieces(motion):
        both = powers(motion.velocity[piece], motion.period_s, motion.band_hz)
        loud, slow = (np.sqrt(means(each)) for each in both)
        found.append((means(motion.time_s[piece]), loud, slow))
    return found


def motions(
    traces: SessionTraces, scenario: Scenario | None, since_s: float = 0.0
) -> list[Motion]:
    """Return what is judged of a session, from ``since_s`` on at the earliest: the motion of every
    device and, while a user touches it, of the object.
    """
    server = traces.server
    band, images = th.DEFAULT_BAND_HZ, 0.0
    since_s, since = max((since_s, ""), _disturbed(traces, scenario))
    if scenario is not None:
        last = stages(traces, scenario)[-1]
        closing = any(2.0 * closed_s(u, scenario) > traces.duration_s for u in traces.users)
        band, images = bands(last.scenario, closing=closing)
    known = {user.name: user for user in scenario.users} if scenario else {}
    of = partial(Motion, band_hz=band, images=images, since_s=since_s, since=since)
    found = []
    for user in traces.users:
        moved, noise = _of_device(user, known.get(user.name))
        found.append(of(f"{user.name}'s device", user.time_s, user.tick_s, moved, noise_m_s=noise))
    if server is not None:
        period_s = float([server.period_s, *server.periods_s][-1])
        there = server.time_s < traces.duration_s  # it runs on behind its users
        held = server.xd_o * np.any(server.contact, axis=0)[:, np.newaxis]
        found.append(of("the object", server.time_s[there], period_s, held[there]))
    return found


def _of_device(traces: UserTraces, user: User | None) -> tuple[Array, float]:
    """Return the velocity of a device, ``(tick, dof)`` [m/s], and twice the RMS of what an
    encoder's steps alone make of it. Of one that is the difference of positions the mean over a
    frame is judged: each position is uniform within a step q, which makes q / (frame sqrt 6).
    """
    if user is None or not user.device.differences:
        return traces.xd_m, 0.0
    rows, frame_s = np.arange(len(traces.time_s)), user.master.frame_s
    before = np.maximum(rows - user.master.rate_drop, 0)
    lasted_s = np.maximum(traces.time_s - traces.time_s[before], frame_s)[:, np.newaxis]
    noise_m_s = 2.0 * float(user.device.encoder_step_m) / (frame_s * math.sqrt(6.0))
    return (traces.x_m - traces.x_m[before]) / lasted_s, noise_m_s


def _disturbed(traces: SessionTraces, scenario: Scenario | None) -> tuple[float, str]:
    """Return when a motion was last disturbed by no fault of the loop [s], and by what: a changed
    parameter, a stop of a device, contact made or lost, by whichever user. What comes and goes
    until the end is the loop's own motion. Users that leave at the end of the session disturb
    nobody: the server runs on behind them.
    """
    server, found = traces.server, [(0.0, "")]
    if scenario is not None:
        found.append((stages(traces, scenario)[-1].start_s, "a parameter changed"))
    ends = [float(user.time_s[-1]) for user in traces.users if len(user.time_s)]
    end_s = min([end for end in ends if end > traces.duration_s - th.LEAVING_S], default=np.inf)
    changes = [(stops_s(user, scenario), "a device met its stop") for user in traces.users]
    if server is not None:
        made = (server.time_s[1:][np.diff(contact.astype(int)) != 0] for contact in server.contact)
        changes += [(times, "contact was made or lost") for times in made]
    for times, what in changes:
        times = times[times <= end_s]
        late = times[times > 0.5 * traces.duration_s]
        often = len(late) > th.CHATTER
        if len(times) and not (often and traces.duration_s - late[-1] <= np.diff(late).max()):
            found.append((float(times[-1]), what))
    return max(found)
