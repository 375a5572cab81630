# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on the stability of a session, from the motion itself.

In this order:

``diverged``
    a position is not finite or more than half the workspace outside of it, or an oscillation grows
    beyond 50 mm/s in a loop that is not passive.
``limited by safety``
    a fault, repeated braking for speed, or forces shortened again and again (events/limits.py).
``environment lost``
    the energy limit of a black box's port displaced the device too far (events/limits.py).
``sustained oscillation``
    motion faster than anybody's on purpose that does not die out (oscillation.py), or one that
    the loop drove at any time (drive.py).

Not judged is what fades too slowly to tell, what hands did where no exact model decays, contact
made or lost or a parameter changed just before the end, packets that came unevenly
(traces/arrivals.py) unless the loop is seen to drive the motion (drive.py), and a device that
never moved. Where a verdict contradicts the exact model, the words say so.
"""

import math
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.criterion import tolerance
from pmwvc_analysis.budget.energy import server_sums, user_energies
from pmwvc_analysis.events import limits
from pmwvc_analysis.events.nodes import COUPLED
from pmwvc_analysis.prediction.prediction import growth_per_s
from pmwvc_analysis.recording.topics import relayed
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.arrivals import waited
from pmwvc_analysis.traces.felt import touching
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.verdicts.drive import UNKNOWN, LoopWork, drive, kept_driven, works
from pmwvc_analysis.verdicts.oscillation import Motion, Strength, lasts, motions, strength
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

LIMITED, SUSTAINED = "limited by safety", "sustained oscillation"


class Verdict(NamedTuple):
    """Stable, unstable (then ``instability`` is its kind) or not known (None), what showed it, and
    the strongest late oscillation [m/s].
    """

    stable: bool | None
    instability: str | None
    why: str
    oscillation_m_s: float = 0.0


def verdict(traces: SessionTraces, scenario: Scenario | None, *, since_s: float = 0.0) -> Verdict:
    """Judge one session; what goes on at its end is judged from ``since_s`` on at the earliest."""
    moved = motions(traces, scenario, since_s)
    found = [(strength(motion, traces.duration_s), motion) for motion in moved]
    strongest = max((each.late_m_s for each, _ in found), default=0.0)
    done = works(traces, scenario)
    judged = _judged(traces, scenario, found, done)
    if judged.stable is not False and (driven := kept_driven(traces, scenario, moved, done)):
        judged = Verdict(False, SUSTAINED, driven)
    return judged._replace(oscillation_m_s=strongest)


def _judged(
    traces: SessionTraces, scenario: Scenario | None, strengths: list[tuple[Strength, Motion]],
    done: list[LoopWork],
) -> Verdict:  # fmt: skip
    outside, left_s = outside_of(traces, scenario)
    until = drive(traces, scenario, 0.0, left_s, done) if left_s > 0.0 else UNKNOWN
    if until.thrown and not _expected(traces, scenario)[0] > th.GROWS_PER_S:
        did = "the hands did" if until.given_j else "it is not known who did"
        return _unknown(f"{outside}; {did} the work of it")
    if left_s > 0.0 and passive(traces, scenario):
        return _unknown(f"{outside}, and every port is passive: the loop did not make the energy")
    if outside:
        return Verdict(False, "diverged", outside)
    lasting = [(found, motion) for found, motion in strengths if lasts(found, motion)]
    links = [packets for topic, packets in traces.packets.items() if relayed(topic)]
    since_s = max([0.5 * traces.duration_s, *(motion.since_s for _, motion in lasting)])
    shaken = waited(links, since_s, traces.duration_s)
    late = drive(traces, scenario, since_s, traces.duration_s, done) if lasting else UNKNOWN
    shown = shaken <= th.UNEVEN and not late.by_hands
    own = lasting if shown else []
    for found, motion in own:
        if found.late_m_s > th.GROWN_M_S and found.growth >= th.GROWN:
            why = f"{motion.name} oscillates with {found.late_m_s * 1e3:.0f} mm/s, growing"
            model = _expected(traces, scenario)[1]
            kind = SUSTAINED if passive(traces, scenario) else "diverged"
            return Verdict(False, kind, "; ".join(filter(None, (why, model))))
    if took_over := limits.taken_over(traces):
        return Verdict(False, LIMITED, took_over)
    shortened, saturated = limits.often_shortened(traces)
    if shortened and (own or not saturated):
        return Verdict(False, LIMITED, shortened)
    if shortened:
        half = drive(traces, scenario, 0.5 * traces.duration_s, traces.duration_s, done)
        gave = half.share > th.DRIVES
        whose = "the loop gave energy" if gave else "a hand may have pushed harder"
        nothing = f"nothing oscillates beyond the voluntary band: {whose}"
        return _unknown(f"{shortened}, to the largest that is allowed; {nothing}")
    if lost := limits.lost(limits.withheld(traces, scenario)):
        return Verdict(False, "environment lost", lost)
    explained = ""
    if lasting:
        found, motion = min(own or lasting, key=lambda pair: pair[0].fades)
        if own or not late.by_hands:
            return _of_lasting(found, motion, traces, scenario, shaken=None if own else shaken)
        rate_per_s, model = _expected(traces, scenario)
        if not found.settled:
            return _unsettled(found, motion, traces)
        moves = f"{motion.name} moves with {found.late_m_s * 1e3:.1f} mm/s"
        explained = f"{moves} beyond the voluntary band, not seen to come from the loop"
        if not rate_per_s < th.GROWS_PER_S:
            return _unknown(f"{explained}: whether the loop keeps it up is not known")
        explained = f"{explained}; {model}"
    if (length_s := traces.duration_s) < th.SHORTEST_S:
        return _unknown(f"{length_s:.2g} s are too short to judge, {th.SHORTEST_S:g} s at least")
    if unknown := ", ".join(motion.name for found, motion in strengths if not found.known):
        return _unknown(f"too little of the motion of {unknown} is known")
    if traces.users and not any((user.state == COUPLED).any() for user in traces.users):
        return _unknown("no user was ever coupled")
    moved = (np.abs(user.xd_m).max() > th.OSCILLATION_M_S for user in traces.users)
    if traces.users and not any(moved):
        return _unknown(f"no device moved faster than {th.OSCILLATION_M_S * 1e3:g} mm/s")
    return Verdict(True, None, explained or _quiet_words([found for found, _ in strengths]))


def _unknown(why: str) -> Verdict:
    return Verdict(None, None, why)


def _unsettled(found: Strength, motion: Motion, traces: SessionTraces) -> Verdict:
    since = f"{motion.since} {traces.duration_s - motion.since_s:.2f} s before the end"
    speed = f"{found.late_m_s * 1e3:.1f} mm/s"
    return _unknown(f"{since}; {motion.name} still moved with {speed}")


def _of_lasting(
    found: Strength, motion: Motion, traces: SessionTraces, scenario: Scenario | None, *,
    shaken: float | None,
) -> Verdict:  # fmt: skip
    """Judge a motion beyond the band that does not die out; ``shaken``: the ratio of time spent
    waiting for late packets, where the loop is not seen to keep the motion up.
    """
    speed = f"{found.late_m_s * 1e3:.1f} mm/s"
    moves = f"{motion.name} moves with {speed} beyond the voluntary band"
    if not found.settled:
        return _unsettled(found, motion, traces)
    if shaken is not None:
        return _unknown(
            f"{moves}, while {shaken:.0%} of the time went by in waiting for late packets: "
            "whether the network or the loop moves it is not known"
        )
    if found.fades:
        return _unknown(
            f"{moves}, {1.0 - found.growth:.0%} less than {found.apart_s:.1f} s earlier: only a "
            "longer session can show whether it dies out"
        )
    expected_per_s, model = _expected(traces, scenario)
    if found.decays_by(expected_per_s):
        return _unknown(
            f"{moves}; its strength changed by {found.growth - 1.0:+.1%} in {found.apart_s:.1f} "
            f"s, and {model}: only a longer session can show whether it is kept up"
        )
    why = f"{motion.name} keeps oscillating with {speed}"
    return Verdict(False, SUSTAINED, "; ".join(filter(None, (why, model))))


def _expected(traces: SessionTraces, scenario: Scenario | None) -> tuple[float, str]:
    """Return the growth rate of the slowest motion that the exact model expects [1/s], of the
    parameters at the end; NaN where there is none. And in words that it decays, if it does.
    """
    rate = None
    if scenario is not None:
        rate = growth_per_s(stages(traces, scenario)[-1].scenario, live=traces.live)
    if rate is None or not rate < th.GROWS_PER_S:
        return math.nan if rate is None else rate, ""
    if rate > -th.NEUTRAL_PER_S:
        return 0.0, "the exact model, hands off, does not grow"
    return rate, f"the exact model, hands off, decays by {-rate:.2g} per second"


def _quiet_words(found: list[Strength]) -> str:
    """Return why motion beyond the voluntary band is no oscillation, with its amount."""
    strongest_m_s = max((each.late_m_s for each in found), default=0.0)
    text = f"motion faster than the voluntary band, {strongest_m_s * 1e3:.1f} mm/s at the end,"
    if strongest_m_s <= th.OSCILLATION_M_S:
        return f"{text} stays below {th.OSCILLATION_M_S * 1e3:g} mm/s"
    if any(each.late_m_s > th.OSCILLATION_M_S and not each.remains for each in found):
        return f"{text} decays"
    return f"{text} is no more than counts of an encoder or sampling make of a slower one"


def passive(traces: SessionTraces, scenario: Scenario | None) -> bool:
    """Tell whether all ports of users are passive, and the server gave and holds no more than it
    took in: the energy of such a loop is bounded.
    """
    energies, server = user_energies(traces, scenario), traces.server
    if server is None or not energies or any(each.passive is not True for each in energies):
        return False
    taken, given, holds = server_sums(server)
    return bool((taken - given - holds >= -tolerance(taken) - tolerance(holds)).all())


def outside_of(traces: SessionTraces, scenario: Scenario | None) -> tuple[str, float]:
    """Return what is not finite or far outside the workspace, in words, and since when [s]; empty
    when nothing is.
    """
    known = scenario.users if scenario else ()
    workspace = max((u.device.workspace_m for u in known), default=th.DEFAULT_WORKSPACE_M)
    positions = [(f"{user.name}'s device", user.x_m, user.time_s) for user in traces.users]
    if (server := traces.server) is not None:
        touched = np.any([touching(server, i) for i in range(len(server.users))], axis=0)
        latest_s = np.maximum.accumulate(np.where(touched, server.time_s, -np.inf))
        held = ~(server.time_s - latest_s >= th.SETTLE_S)  # else it coasts
        held |= ~np.isfinite(server.x_o).all(axis=-1)
        positions.append(("the object", server.x_o[held], server.time_s[held]))
        for name, x_s, state in zip(server.users, server.x_s, server.state, strict=True):
            present = state > 0
            positions.append((f"{name}'s avatar", x_s[present], server.time_s[present]))
    for name, x, time_s in positions:
        if not np.isfinite(x).all():
            return f"{name}: a position is not a number", 0.0
        far = np.flatnonzero(np.abs(x).max(axis=-1, initial=0.0) > th.WORKSPACES * workspace)
        if len(far):
            space = f"the workspace (+-{workspace * 1e3:.0f} mm)"
            return f"{name} left {space} at {time_s[far[0]]:.2f} s", float(time_s[far[0]])
    return "", 0.0
