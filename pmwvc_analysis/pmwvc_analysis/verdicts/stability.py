# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on the stability of a session, from the motion itself.

The exact model decides nothing. Where motion alone cannot tell a slow decay from an oscillation
that is kept up, and the model decays as slowly, there is no verdict; where a verdict contradicts
the model, its words say so.

In this order:

``diverged``
    a signal is not finite, a wave is longer than any that a receiver takes, or a device, avatar or
    the object is more than half the workspace outside of it, or the oscillation (below) grows: at
    least twice as strong at the end as in the middle, and beyond 50 mm/s.
``limited by safety``
    a safety layer reached its fault state; fell back to damping for speed three times or more in
    the second half of the session or for more than a twentieth of it; or shortened the force of a
    coupled device again and again: in more than a twentieth of the second half, in three or more
    separate events. Where that was mostly at the largest force and nothing oscillates (below), the
    hand may have pushed harder than the device can: that is not judged.
``environment lost``
    the energy limit of a black box's port displaced the device so far that most of its
    depth is neither the environment's nor the link's (environment.py).
``sustained oscillation``
    motion faster than anybody's on purpose, the environment's own included, that does not die out:
    in most of the last two thirds of the judged span its RMS velocity is beyond 1 mm/s and beyond
    the sampling images of the purposeful motion, and it does not halve from the first third to the
    last. Where it became less from third to third, by a tenth or more in all, it decays slowly or
    settles at some strength: only a longer session tells, and that is not judged. Nor is a change
    of less than a tenth where the exact model, hands off, decays as slowly, nor where contact was
    made or lost or a parameter changed less than a second before the end, or where packets came
    unevenly (traces/arrivals.py), which moves devices as well, unless the loop is seen to keep the
    motion up (kept_up.py).

What is on purpose, and how the rest is measured: oscillation.py.
"""

import math
from dataclasses import dataclass

import numpy as np

from pmwvc_analysis.events import environment
from pmwvc_analysis.prediction.slowest import growth_per_s
from pmwvc_analysis.recording.format.topics import relayed
from pmwvc_analysis.traces.arrivals import UNEVEN, timely, waited
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.verdicts.kept_up import kept_up
from pmwvc_analysis.verdicts.limits import often_shortened, taken_over
from pmwvc_analysis.verdicts.oscillation import (
    OSCILLATION_M_S,
    SHORTEST_S,
    Strength,
    lasts,
    motions,
    strength,
)
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_core.wave.limits import largest_wave

GROWN_M_S = 50e-3
LIMITED = "limited by safety"
DEFAULT_WORKSPACE_M = 0.2


@dataclass(frozen=True)
class Verdict:
    """Stable or the kind of instability, what showed it, the strongest late oscillation [m/s].

    ``judged`` is False where nothing was found in a recording that lacks too much to judge.
    """

    instability: str | None
    why: str
    oscillation_m_s: float
    judged: bool = True

    @property
    def stable(self) -> bool | None:
        """Tell whether no instability was found; None where that cannot be told."""
        if self.instability is None and not self.judged:
            return None
        return self.instability is None


def verdict(traces: SessionTraces, scenario: Scenario | None) -> Verdict:
    """Judge one session."""
    outside = _outside(traces, scenario) or _beyond(traces, scenario)
    strengths = [
        (strength(motion, traces.duration_s), motion) for motion in motions(traces, scenario)
    ]
    strongest = max((s.late_m_s for s, _ in strengths), default=0.0)
    if outside:
        return Verdict("diverged", outside, strongest)
    lasting = [(found, motion) for found, motion in strengths if lasts(found, motion)]
    links = [packets for topic, packets in traces.packets.items() if relayed(topic)]
    since_s = max([0.5 * traces.duration_s, *(motion.since_s for _, motion in lasting)])
    shaken = waited(links, since_s, traces.duration_s)
    in_time = timely(links, since_s, traces.duration_s)
    own = [
        (found, motion)
        for found, motion in lasting
        if shaken <= UNEVEN or kept_up(found, motion, traces.duration_s, in_time)
    ]
    for found, motion in own:
        if found.late_m_s > GROWN_M_S and found.growth >= 2.0:
            why = f"{motion.name} oscillates with {found.late_m_s * 1e3:.0f} mm/s, growing"
            expected_per_s = _growth_per_s(traces, scenario)
            if expected_per_s < 0.0:
                why += f"; {_beside(expected_per_s)}"
            return Verdict("diverged", why, strongest)
    took_over = taken_over(traces, scenario)
    if took_over:
        return Verdict(LIMITED, took_over, strongest)
    shortened, saturated = often_shortened(traces)
    if shortened and (own or not saturated):
        return Verdict(LIMITED, shortened, strongest)
    if shortened:
        why = (
            f"{shortened}, to the largest that is allowed; nothing oscillates, so a hand may have "
            "pushed harder than that"
        )
        return Verdict(None, why, strongest, judged=False)
    lost = environment.lost(traces, scenario)
    if lost:
        return Verdict("environment lost", lost, strongest)
    for found, motion in sorted(own or lasting, key=lambda pair: pair[0].fades):
        if not found.settled:
            changed = scenario and stages(traces, scenario)[-1].start_s == motion.since_s
            why = (
                f"{'a parameter changed' if changed else 'contact was made or lost'} "
                f"{traces.duration_s - motion.since_s:.2f} s before the end; {motion.name} still "
                f"moved with {found.late_m_s * 1e3:.1f} mm/s"
            )
            return Verdict(None, why, strongest, judged=False)
        if not own:
            why = (
                f"{motion.name} moves with {found.late_m_s * 1e3:.1f} mm/s beyond the voluntary "
                f"band, while {shaken:.0%} of the time went by in waiting for late packets, and "
                "is not seen to go on by itself between them: whether the network or the loop "
                "moves it is not known"
            )
            return Verdict(None, why, strongest, judged=False)
        if found.fades:
            why = (
                f"{motion.name} moves with {found.late_m_s * 1e3:.1f} mm/s beyond the voluntary "
                f"band, {1.0 - found.growth:.0%} less than {found.apart_s:.1f} s earlier: only a "
                "longer session can show whether it dies out"
            )
            return Verdict(None, why, strongest, judged=False)
        expected_per_s = _growth_per_s(traces, scenario)
        if found.decays_by(expected_per_s):
            why = (
                f"{motion.name} moves with {found.late_m_s * 1e3:.1f} mm/s beyond the voluntary "
                f"band; its strength changed by {found.growth - 1.0:+.1%} in {found.apart_s:.1f} "
                f"s, and {_beside(expected_per_s)}: only a longer session can show whether it is "
                "kept up"
            )
            return Verdict(None, why, strongest, judged=False)
        why = f"{motion.name} keeps oscillating with {found.late_m_s * 1e3:.1f} mm/s"
        if expected_per_s < 0.0:
            why += f"; {_beside(expected_per_s)}"
        return Verdict("sustained oscillation", why, strongest)
    if traces.duration_s < SHORTEST_S:
        why = f"{traces.duration_s:.2g} s are too short to judge, {SHORTEST_S:g} s at least"
        return Verdict(None, why, strongest, judged=False)
    unknown = [motion.name for found, motion in strengths if not found.known]
    if unknown:
        why = f"too little of the motion of {', '.join(unknown)} was recorded"
        return Verdict(None, why, strongest, judged=False)
    return Verdict(None, _quiet_words([found for found, _ in strengths], strongest), strongest)


def _growth_per_s(traces: SessionTraces, scenario: Scenario | None) -> float:
    """Return the growth rate of the slowest motion that the exact model expects [1/s], of the
    parameters at the end; NaN where it expects none.
    """
    if scenario is None:
        return math.nan
    found = growth_per_s(stages(traces, scenario)[-1].scenario, live=traces.live)
    return math.nan if found is None else found


def _beside(expected_per_s: float) -> str:
    return f"the exact model, hands off, decays by {-expected_per_s:.2g} per second"


def _quiet_words(found: list[Strength], strongest_m_s: float) -> str:
    """Return why motion beyond the voluntary band is no oscillation, with its amount."""
    text = f"motion faster than the voluntary band, {strongest_m_s * 1e3:.1f} mm/s at the end,"
    if strongest_m_s <= OSCILLATION_M_S:
        return f"{text} stays below {OSCILLATION_M_S * 1e3:g} mm/s"
    if any(each.late_m_s > OSCILLATION_M_S and not each.remains for each in found):
        return f"{text} decays"
    return f"{text} is no more than counts of an encoder or sampling make of a slower one"


def _beyond(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return whose waves are longer than any that a receiver takes, in words; else empty."""
    if scenario is None or not has_waves(scenario.controller):
        return ""
    known = [
        {user.name: user for user in stage.scenario.users} for stage in stages(traces, scenario)
    ]
    sent = [(user.name, f"{user.name}'s master", user.u_m, user.time_s) for user in traces.users]
    server = traces.server
    if server is not None:
        rows = zip(server.users, server.v_s, strict=True)
        sent += [(name, f"{name}'s server port", v, server.time_s) for name, v in rows]
    for name, end, wave, time_s in sent:
        if name not in known[0]:
            continue
        each = [
            b for users in known for b in (users[name].impedance, users[name].server_impedance)
        ]
        longest = max(largest_wave(b, waves=True) for b in each)
        far = np.flatnonzero(np.linalg.norm(np.nan_to_num(wave), axis=-1) > longest)
        if len(far):
            return (
                f"{end} sent waves beyond {longest:.3g} sqrt(W), which receivers reject, from "
                f"{time_s[far[0]]:.2f} s on"
            )
    return ""


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
