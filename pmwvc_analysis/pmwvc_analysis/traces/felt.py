# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a hand feels and does: steps, buzz and lack of its force, and the band in which it moves.

A *step* is a change of the applied force within 1 ms, a *blow* one of more than ``BLOW_N`` and
more than the largest force F changes by in the hand's own band f, 2 pi f F in a second; *buzz* is
the RMS of the applied force above ``BUZZ_HZ`` while the master is coupled, by a high pass without
phase (:func:`.sums.beyond`): images of purposeful motion are what it counts. Of all, what an
impact, or a body that slips out of a grip, makes within ``IMPACT_S`` is left out. The *undisturbed
force* of a hand that means to hold one is the median while the master is coupled and the avatar
touches, of the best such stretch that is longer than an impact, from ``BLOW_N`` on.

*Disturbed* is a user that is not coupled, or has less than half of that force once it was felt,
though the scenario does not take it away: at the start, in outages of a link, while a node that it
kills or stops does not run, each with the time to be coupled again; and what slips out of a grip.

The *voluntary band* has the frequencies at which hands and environments move on purpose. For a
target that rests, hands move below half a hertz; while they close, below 6 Hz over the duration of
the closing in s. Packets and server steps make images of purposeful motion: of motion at f sampled
at f_s and held, one at f_s - f with f/(f_s - f) of its size. The drive of somebody else's
environment is not known: its motion counts as the loop's.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.holes import block_of_ticks, gaps
from pmwvc_analysis.traces.stages import disturbances
from pmwvc_analysis.traces.sums import HIGHEST, begins, beyond, rms, spans
from pmwvc_core.frame import Presence
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.effects import mean_s
from pmwvc_core.network.in_flight import Cause
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.params import OperatorParams, TaskParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.words import count


class Felt(NamedTuple):
    """The steps, dropouts and buzz of a user's force; None: not defined."""

    force_step_max_n: float  # largest step, and when
    force_step_max_s: float
    blows: int  # how often one began
    force_undisturbed_n: float | None = None
    force_least_n: float | None = None  # since the undisturbed force was first felt
    dropout_s: float | None = None  # time since then below half of the undisturbed force
    coupled_ratio: float = 0.0  # of its time
    buzz_n: float | None = None  # None: never coupled for 0.25 s without an impact
    disturbed_s: float | None = None  # None without a scenario


def felt(traces: SessionTraces, user: UserTraces, scenario: Scenario | None) -> Felt:
    """Return what a user felt."""
    known = next((u for u in scenario.users if u.name == user.name), None) if scenario else None
    server = traces.server
    if server is not None and (user.name not in server.users or not len(server.time_s)):
        server = None
    broken = np.zeros(len(user.time_s), dtype=bool)  # no tick on record before
    broken[gaps(user) + 1] = True
    broken[1:] |= np.diff(user.tick) < 0
    coupled = user.state[block_of_ticks(user)] == SafetyState.COUPLED
    together, made_s = np.zeros(len(user.time_s), dtype=bool), [stops_s(user, scenario)]
    if server is not None:
        index = server.users.index(user.name)
        touches = touching(server, index)
        slipped = ~touches & bool(scenario and scenario.environment.outside)  # out of a grip
        made_s.append(server.time_s[begins(touches) | begins(slipped)])
        row = np.searchsorted(server.time_s, user.time_s, side="right") - 1
        avatar = server.state[index][row] == Presence.COUPLED
        together = np.asarray(coupled & avatar & (row >= 0))
    latest_s = np.append(-np.inf, np.sort(np.concatenate(made_s)))
    latest_s = latest_s[np.searchsorted(latest_s, user.time_s, side="right") - 1]
    impact = user.time_s < latest_s + th.IMPACT_S
    lasted_s = np.append(np.diff(user.time_s), user.tick_s)  # as far as that is on record
    lasted_s[:-1][broken[1:]] = user.tick_s
    steps = np.where(impact, 0.0, _steps(user, broken))
    worst, size = int(np.argmax(steps)), np.linalg.norm(user.f_applied, axis=-1)
    band_hz = operator_band_hz(known.operator, scenario.task) if scenario and known else 0.0
    smooth_n = 2.0 * math.pi * band_hz * float(np.nan_to_num(size).max()) * th.STEP_S
    blows = int(begins(steps > max(th.BLOW_N, smooth_n)).sum())
    found = Felt(
        float(steps[worst]), float(user.time_s[worst]), blows,
        coupled_ratio=float(lasted_s[together].sum() / lasted_s.sum()),
        buzz_n=_buzz_n(user, coupled & ~impact & ~broken),
    )  # fmt: skip
    if scenario is None or known is None:
        return found
    away = _taken_away(traces, user, known, scenario.task)
    found = found._replace(disturbed_s=float(lasted_s[~together & ~away].sum()))
    holds = known.device.is_simulated and known.operator.kind in ("hand", "constant")
    if server is None or not holds:
        return found
    held = together & touches[np.maximum(row, 0)] & np.isfinite(size)
    closed = held & (user.time_s >= closed_s(user, scenario))
    long = [size[span] for span in spans(closed) if lasted_s[span].sum() >= th.IMPACT_S]
    undisturbed_n = max((float(np.median(each)) for each in long), default=0.0)
    felt_at = closed & (size >= undisturbed_n)
    if undisturbed_n < th.BLOW_N or not felt_at.any():
        return found
    since = slice(int(np.argmax(felt_at)), None)
    below = size < 0.5 * undisturbed_n
    if scenario.environment.outside:  # it may slip out of a grip, and be touched again
        pushes = np.linalg.norm(server.f_s[index], axis=-1) >= 0.5 * undisturbed_n
        below &= ~together | (pushes[row] & ~impact)
    below[: since.start] = False
    return found._replace(
        force_undisturbed_n=undisturbed_n,
        force_least_n=float(np.nanmin(size[since])),
        dropout_s=float(lasted_s[below].sum()),
        disturbed_s=float(lasted_s[(below | ~together) & ~away].sum()),
    )


def touching(server: ServerTraces, index: int) -> Flags:
    """Tell at which steps an avatar touches: by its force where no contact is known."""
    touches = np.asarray(server.contact[index], dtype=bool)
    if touches.any() or server.poses:
        return touches
    return np.asarray(np.nan_to_num(np.linalg.norm(server.f_s[index], axis=-1)) > th.TOUCH_N)


def stops_s(user: UserTraces, scenario: Scenario | None) -> Array:
    """Return when a device came to a stop of its workspace, or left one [s]; a turn has none."""
    users = scenario.users if scenario else ()
    if (device := next((u.device for u in users if u.name == user.name), None)) is None:
        return np.zeros(0)
    stopped = np.abs(user.x_m[:, :3]) >= device.workspace_m - 0.5 * device.encoder_step_m
    return np.asarray(user.time_s[1:][np.diff(stopped, axis=0).any(axis=-1)])


def closed_s(user: UserTraces, scenario: Scenario) -> float:
    """Return when a simulated hand has closed [s]; 0 where none does or its start is unknown."""
    hands = {known.name for known in scenario.users if known.operator.is_hand}
    coupled = user.block_time_s[user.state == SafetyState.COUPLED]
    unknown = not len(coupled) or (user.state[0] == SafetyState.COUPLED and user.time_s[0] > 0.0)
    if not scenario.task.closes or user.name not in hands or unknown:
        return 0.0
    return float(coupled[0]) + scenario.task.grip_s + scenario.task.grip_rise_s


def _taken_away(traces: SessionTraces, user: UserTraces, known: User, task: TaskParams) -> Flags:
    """Tell at which ticks the scenario takes the coupling of a user away."""
    delays_s = mean_s(known.link_up) + mean_s(known.link_down)
    back_s = th.BACK_S + known.safety.soft_start_s + delays_s
    server_s = traces.server.time_s[:1] if traces.server is not None else ()
    found = [(0.0, float(max([user.time_s[0], *server_s])))]
    zeros = traces.metadata.get("fate_zero_ns", {})
    for name, fates in traces.fates.items():
        lost_ns = fates.time_in_ns[fates.cause == Cause.OUTAGE] - zeros.get(name, 0)
        found += [(time_s, time_s) for time_s in (lost_ns * 1e-9).tolist()]
    found += _stood_still(traces, task.grip_s + task.grip_rise_s if task.closes else 0.0)
    away = np.zeros(len(user.time_s), dtype=bool)
    for start_s, end_s in found:
        away[slice(*np.searchsorted(user.time_s, (start_s, end_s + back_s)))] = True
    return away


def _stood_still(traces: SessionTraces, closing_s: float) -> Iterator[tuple[float, float]]:
    """Yield from when to when nodes did not run because the scenario asked for it [s]; the hand of
    a master that is started again has to close again.
    """
    ran_s = {f"{user.name} master": user.time_s for user in traces.users}
    up = (traces.packets.get(f"/server/{user.name}/wave_up") for user in traces.users)
    ran_s["netem"] = np.sort(np.concatenate([[], *(each.time_s for each in up if each)]))
    ran_s["server"] = traces.server.time_s if traces.server is not None else np.zeros(0)
    since_s: dict[str, float] = {}
    for who, action, time_s in disturbances(traces):
        if action in ("kill", "stop"):
            since_s.setdefault(who, time_s)
        elif who in since_s and who in ran_s:
            later = ran_s[who][ran_s[who] >= time_s]
            closing = closing_s * (action == "start" and who.endswith("master"))
            yield since_s.pop(who), float(later.min(initial=traces.duration_s)) + closing
    yield from ((since_s[who], traces.duration_s) for who in since_s.keys() & ran_s.keys())


def _steps(user: UserTraces, broken: Flags) -> Array:
    """Return by how much the force differs from one up to 1 ms before, for each tick [N]."""
    force, piece = user.f_applied, np.cumsum(broken)
    steps = np.zeros(len(force))
    for lag in range(1, max(1, round(th.STEP_S / user.tick_s)) + 1):
        size = np.linalg.norm(force[lag:] - force[:-lag], axis=-1)
        size = np.where((piece[lag:] == piece[:-lag]) & np.isfinite(size), size, 0.0)
        steps[lag:] = np.maximum(steps[lag:], size)
    return steps


def _buzz_n(user: UserTraces, counts: Flags) -> float | None:
    """Return the RMS of the force above ``BUZZ_HZ``, stretch by stretch of what counts [N]."""
    found = spans(counts & np.isfinite(user.f_applied).all(axis=-1))
    parts = [user.f_applied[s] for s in found if (s.stop - s.start) * user.tick_s >= th.WINDOW_S]
    fast = [beyond(part, user.tick_s, th.BUZZ_HZ) for part in parts]
    return rms(np.concatenate(fast)) if fast and th.BUZZ_HZ * user.tick_s < HIGHEST else None


def felt_words(found: Mapping[str, Any]) -> str:
    """Return what a user felt (:class:`Felt`, by name) in words."""
    parts = [f"steps of force up to {round(found['force_step_max_n'], 4):.2g} N in 1 ms"]
    if (buzz_n := found["buzz_n"]) is not None:
        parts.insert(0, f"buzz {round(buzz_n, 4):.2g} N rms above {th.BUZZ_HZ:g} Hz")
    if found["blows"]:
        parts[-1] += f" ({count(found['blows'], 'blow')} above {th.BLOW_N:g} N)"
    if (held_n := found["force_undisturbed_n"]) is not None:
        missing = f"{1e3 * found['dropout_s']:.0f} ms" if found["dropout_s"] else "never"
        parts.append(f"{missing} below half of {held_n:.2f} N")
    return ", ".join(parts)


def operator_band_hz(operator: OperatorParams, task: TaskParams) -> float:
    """Return the frequency below which an operator moves on purpose; one with a pointer, who lets
    the handle go and takes it, is as fast as a recorded one.
    """
    if operator.is_hand:
        return max(2.0, th.MINIMUM_JERK / task.move_rise_s) if task.moves else th.REST_BAND_HZ
    if operator.is_sinusoid:
        return max(th.REST_BAND_HZ, th.HARMONICS * operator.frequency_hz)
    if operator.is_chirp:
        return 1.5 * max(operator.frequency_hz, operator.frequency_end_hz)
    return th.RECORDED_HZ if operator.is_remote or operator.is_recorded else th.REST_BAND_HZ


def bands(scenario: Scenario, *, closing: bool) -> tuple[float, float]:
    """Return the band of a session [Hz], that of the fastest hand and of the environment, and the
    largest ratio of sampling images to purposeful motion. ``closing``: hands close in that time.
    """
    hands = [user.operator for user in scenario.users]
    band = max(operator_band_hz(hand, scenario.task) for hand in hands)
    band = max(band, th.HARMONICS * scenario.environment.drive_hz(scenario.server))
    if closing:
        band = max(band, th.MINIMUM_JERK / scenario.task.grip_rise_s)
    driven = all(hand.is_sinusoid for hand in hands)
    highest = max(hand.frequency_hz for hand in hands) if driven else band
    slowest = max(scenario.server.period_s, *(user.master.frame_s for user in scenario.users))
    return band, highest / max(1.0 / slowest - highest, highest)
