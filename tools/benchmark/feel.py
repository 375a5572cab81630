# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the hands feel in a session, in a few numbers; of several users the worst one's."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.felt import felt
from pmwvc_analysis.traces.thresholds import BUZZ_HZ
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import place_of
from pmwvc_core.traces import SessionTraces

NEAR_HZ = 2.0
BEGUN_S = 1.0  # until the force of a device is fully there
LONGEST_LAG_S = 2.0  # looked for
LEAST_N = 0.1  # of a press: below it there is none


def peak_n(traces: SessionTraces) -> float:
    """Return the largest force rendered [N]."""
    return max(float(np.linalg.norm(user.f_applied, axis=-1).max()) for user in traces.users)


class Worst(NamedTuple):
    """What :mod:`pmwvc_analysis.traces.felt` finds, of the worst user."""

    step_n: float  # largest change of force within 1 ms
    buzz_n: float | None  # None: nobody was coupled for long enough without an impact
    dropout_s: float  # below half of the force of a hand that holds something


def worst(traces: SessionTraces, scenario: Scenario) -> Worst:
    """Return what the worst user felt."""
    found = [felt(traces, user, scenario) for user in traces.users]
    buzz = [each.buzz_n for each in found if each.buzz_n is not None]
    lost = [traces.duration_s if one.dropout_s is None else one.dropout_s for one in found]
    return Worst(max(one.force_step_max_n for one in found), max(buzz, default=None), max(lost))


def held_share(traces: SessionTraces, scenario: Scenario) -> float:
    """Return the share of that (of its square) within 2 Hz of multiples of the rates of packets
    and server steps: what waves make that are held in between.
    """
    most = held = 0.0
    for user, known in zip(traces.users, scenario.users, strict=True):
        force = user.f_applied[user.time_s >= BEGUN_S, 0]
        power = np.abs(np.fft.rfft(force - force.mean())) ** 2
        hertz = np.fft.rfftfreq(len(force), user.tick_s)
        rates = np.array([known.master.frame_s, scenario.server.period_s])[:, np.newaxis]
        apart = np.abs(hertz * rates - np.round(hertz * rates)) / rates
        fast = hertz >= BUZZ_HZ
        most += float(power[fast].sum())
        held += float(power[fast & (apart.min(axis=0) <= NEAR_HZ)].sum())
    return held / most if most > 0.0 and np.isfinite(most) else 0.0


def contact_n(traces: SessionTraces) -> float | None:
    """Return the RMS of the force at the contacts [N]; None where there is no server."""
    if traces.server is None:
        return None
    squares = [float(np.mean(np.sum(force**2, axis=-1))) for force in traces.server.f_s]
    return float(np.sqrt(np.mean(squares)))


def lag_s(traces: SessionTraces) -> float | None:
    """Return the time by which the avatars follow their devices [s]: the slope of their distance
    over the velocity; None where they were never coupled.
    """
    found = []
    for user in traces.users:
        error = apart(traces, user)
        if error is None or not np.isfinite(error.error).all():
            return None
        velocity = user.xd_m[user.rows_at(error.time_s)]
        square = float(np.sum(velocity**2))
        found.append(float(np.sum(velocity * error.error)) / square if square > 0.0 else 0.0)
    return max(found, default=None)


def lag_free_error_n(traces: SessionTraces) -> float | None:
    """Return the RMS of the force rendered less the contact force one lag earlier, of the lag of
    each user that makes it least [N]; None where there is no server.
    """
    errors = [
        min(
            float(np.mean(np.sum((rendered[lag:] - force[: len(force) - lag]) ** 2, axis=-1)))
            for lag in range(lags)
        )
        for rendered, force, lags in _forces(traces)
    ]
    return float(np.sqrt(np.mean(errors))) if errors else None


def _forces(traces: SessionTraces) -> Iterator[tuple[Array, Array, int]]:
    """Yield for each user the forces rendered and at the contact, step by step while coupled, and
    how many lags are looked at.
    """
    server = traces.server
    if server is None:
        return
    for user, force, state in zip(traces.users, server.f_s, server.state, strict=True):
        coupled = np.flatnonzero(state == Presence.COUPLED)
        steps = slice(coupled[0], None) if len(coupled) else slice(0)
        rows = np.searchsorted(user.time_s, server.time_s[steps] - 0.5 * user.tick_s)
        rendered = user.f_applied[np.clip(rows, 0, len(user.time_s) - 1)]
        lags = min(round(LONGEST_LAG_S / server.period_s), len(rows) // 2)
        if lags:
            yield rendered, force[steps], lags


def pressed(traces: SessionTraces, scenario: Scenario) -> tuple[float, float]:
    """Return stiffness felt [N/m] and dropouts [s] of the presses on a wall, in the second half of
    the time for which the hand's target rests in it: mean force over mean depth of the device.
    """
    user, server = traces.users[0], traces.server
    if server is None:
        return 0.0, traces.duration_s
    target = server.target[:, 0]
    deep = target >= 0.999 * scenario.task.distance_m
    begin = np.flatnonzero(np.diff(deep.astype(int), prepend=0) == 1)
    late = np.zeros(len(user.time_s), dtype=bool)
    for row in begin:
        rows = server.time_s[row] + 0.5 * scenario.task.rest_s, server.time_s[row]
        late |= (user.time_s >= rows[0]) & (user.time_s < rows[1] + scenario.task.rest_s)
    late &= user.time_s < server.time_s[deep][-1] if deep.any() else False
    of = scenario.users[0]
    place = place_of(of, scenario)
    depth = -of.side * (user.x_m[late, 0] - of.side * place.half_width_m)
    force = -of.side * user.f_applied[late, 0]
    if not len(force) or force.mean() <= LEAST_N:
        return 0.0, float(late.sum()) * user.tick_s
    stiffness = float(force.mean() / depth.mean()) if depth.mean() > 0.0 else 0.0
    lost = force < 0.5 * np.median(force)
    return stiffness, float(lost.sum()) * user.tick_s


def moved(traces: SessionTraces) -> tuple[float, float]:
    """Return mass [kg] and damping [N s/m] that the link adds to a device in free motion: those
    whose forces fit the force rendered.
    """
    user = traces.users[0]
    rows = user.time_s >= BEGUN_S
    velocity = user.xd_m[rows, 0]
    parts = np.stack([np.gradient(velocity, user.tick_s), velocity], axis=1)
    (mass, damping), *_ = np.linalg.lstsq(parts, user.f_applied[rows, 0])
    return float(mass), float(damping)
