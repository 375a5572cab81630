# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on the stability of a session, from the motion itself.

In this order:

``diverged``
    a position is not finite or more than half the workspace outside of it, or an oscillation grows
    beyond 50 mm/s in a loop that is not passive.
``limited by safety``
    a fault or repeated braking for speed, or forces shortened again and again (events/limits.py).
``environment lost``
    the energy limit of a black box's port displaced the device too far (events/limits.py).
``sustained oscillation``
    motion faster than anybody's on purpose that does not die out (oscillation.py), or one that
    the loop drove at any time (drive.py).

Not judged is what fades too slowly to tell, what hands did where no exact model decays, contact
made or lost or a parameter changed just before the end, packets that came unevenly
(traces/arrivals.py) unless the loop is seen to drive the motion (drive.py), a device that never
moved, was lost, or hands threw. Where a verdict contradicts the exact model, the words say so.
"""

import math
from collections.abc import Iterator
from functools import cached_property
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
from pmwvc_analysis.verdicts.drive import UNKNOWN, Drive, drive, kept_driven, works
from pmwvc_analysis.verdicts.oscillation import Strength, motions, strength
from pmwvc_core.numeric import Array
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
    return _Judge(traces, scenario, since_s).verdict()


def _unknown(why: str) -> Verdict:
    return Verdict(None, None, why)


class _Judge:
    def __init__(self, traces: SessionTraces, scenario: Scenario | None, since_s: float) -> None:
        self.traces, self.scenario = traces, scenario
        moved = motions(traces, scenario, since_s)
        self.found = [strength(motion, traces.duration_s) for motion in moved]
        self.works = works(traces, scenario)

    def verdict(self) -> Verdict:
        """Judge the end, then what went on at any time."""
        judged = self._outside() or self._at_end()
        if judged.stable and (unknown := self._shows_nothing()):
            judged = _unknown(unknown)
        given = self.traces, self.scenario, [each.motion for each in self.found], self.works
        if judged.stable is not False and (driven := kept_driven(*given)):
            judged = Verdict(False, SUSTAINED, driven)
        strongest = max((each.late_m_s for each in self.found), default=0.0)
        return judged._replace(oscillation_m_s=strongest)

    @cached_property
    def _expected(self) -> tuple[float, str]:
        """The growth rate of the slowest motion that the exact model expects [1/s], of the
        parameters at the end; NaN where there is none. And in words that it does not grow.
        """
        rate = None
        if self.scenario is not None:
            last = stages(self.traces, self.scenario)[-1]
            rate = growth_per_s(last.scenario, live=self.traces.live)
        if rate is None or not rate < th.GROWS_PER_S:
            return math.nan if rate is None else rate, ""
        if rate > -th.NEUTRAL_PER_S:
            return 0.0, "the exact model, hands off, does not grow"
        return rate, f"the exact model, hands off, decays by {-rate:.2g} per second"

    def _unstable(self, kind: str, why: str) -> Verdict:
        return Verdict(False, kind, "; ".join(filter(None, (why, self._expected[1]))))

    def _outside(self) -> Verdict | None:
        """Judge what is not finite or far outside the workspace; None when nothing is."""
        known = self.scenario.users if self.scenario else ()
        workspace = max((u.device.workspace_m for u in known), default=th.DEFAULT_WORKSPACE_M)
        for name, x, time_s in _positions(self.traces):
            if not np.isfinite(x).all():
                return Verdict(False, "diverged", f"{name}: a position is not a number")
            far = np.flatnonzero(np.abs(x).max(axis=-1, initial=0.0) > th.WORKSPACES * workspace)
            if len(far):
                left_s, space = float(time_s[far[0]]), f"(+-{workspace * 1e3:.0f} mm)"
                why = f"{name} left the workspace {space} at {left_s:.2f} s"
                return self._thrown("diverged", why, 0.0, left_s)
        return None

    def _thrown(self, kind: str, why: str, start_s: float, end_s: float) -> Verdict:
        """Judge what was too fast or too far: not the loop's if it gave the hands no more than
        they gave it until then, or made no energy.
        """
        found = drive(self.traces, self.scenario, start_s, end_s, self.works)
        got_no_more = found.by_hands and found.given_j <= 0.0
        if got_no_more and not self._expected[0] > th.GROWS_PER_S:
            did = "the hands did" if found.given_j else "it is not known who did"
            return _unknown(f"{why}; {did} the work of it")
        if passive(self.traces, self.scenario):
            return _unknown(f"{why}, and every port is passive: the loop did not make the energy")
        return Verdict(False, kind, why)

    def _at_end(self) -> Verdict:
        traces, end_s = self.traces, self.traces.duration_s
        lasting = [found for found in self.found if found.lasts]
        links = [packets for topic, packets in traces.packets.items() if relayed(topic)]
        since_s = max([0.5 * end_s, *(found.motion.since_s for found in lasting)])
        waiting, shaken = "", waited(links, since_s, end_s)
        if shaken > th.UNEVEN:
            waiting = f"while {shaken:.0%} of the time went by in waiting for late packets"
        late = UNKNOWN if not lasting else drive(traces, self.scenario, since_s, end_s, self.works)
        own = [] if waiting or late.by_hands else lasting
        for found in own:
            if found.late_m_s > th.GROWN_M_S and found.growth >= th.GROWN:
                kind = SUSTAINED if passive(traces, self.scenario) else "diverged"
                speed = f"{found.late_m_s * 1e3:.0f} mm/s"
                return self._unstable(
                    kind, f"{found.motion.name} oscillates with {speed}, growing"
                )
        took_over, braked_s = limits.taken_over(traces)
        if took_over and braked_s is None:
            return _unknown(took_over)
        if braked_s is not None:
            start_s = max(braked_s - th.SETTLE_S, 0.0)
            return self._thrown(LIMITED, took_over, start_s, braked_s)
        shortened, saturated = limits.often_shortened(traces, self.scenario)
        if shortened and (own or not (saturated or waiting)):
            return Verdict(False, LIMITED, shortened)
        if shortened:
            nothing = "nothing oscillates beyond the voluntary band"
            why = waiting or f"to the largest that is allowed; {nothing}"
            return _unknown(f"{shortened}, {why}")
        for name, entry in limits.withheld(traces, self.scenario).items():
            if entry.lost:
                moved = f"displaced the device by {entry.position_m * 1e3:.1f} mm"
                port = "the energy limit of the server port"
                why = f"{name}: the environment is lost: {port} {moved}"
                return Verdict(False, "environment lost", why)
        if not lasting:
            return Verdict(True, None, _quiet_words(self.found) if self.found else "")
        return self._lasting(min(own or lasting, key=lambda found: found.fades), waiting, late)

    def _lasting(self, found: Strength, waiting: str, late: Drive) -> Verdict:
        """Judge a motion beyond the band that does not die out: ``waiting`` says how long late
        packets were waited for, ``late`` tells who drove the motion.
        """
        motion, speed = found.motion, f"{found.late_m_s * 1e3:.1f} mm/s"
        moves = f"{motion.name} moves with {speed} beyond the voluntary band"
        longer = "only a longer session can show whether it"
        if not found.settled:
            since_s = self.traces.duration_s - motion.since_s
            since = f"{motion.since} {since_s:.2f} s before the end"
            return _unknown(f"{since}; {motion.name} still moved with {speed}")
        if late.by_hands:
            moves += ", not seen to come from the loop"
            if self._expected[0] < th.GROWS_PER_S:
                return Verdict(True, None, f"{moves}; {self._expected[1]}")
            return _unknown(f"{moves}: whether the loop keeps it up is not known")
        if waiting:
            whose = "whether the network or the loop moves it is not known"
            return _unknown(f"{moves}, {waiting}: {whose}")
        if found.fades:
            less = f"{1.0 - found.growth:.0%} less than {found.apart_s:.1f} s earlier"
            return _unknown(f"{moves}, {less}: {longer} dies out")
        if found.decays_by(self._expected[0]):
            change = f"changed by {found.growth - 1.0:+.1%} in {found.apart_s:.1f} s"
            return _unknown(
                f"{moves}; its strength {change}, and {self._expected[1]}: {longer} is kept up"
            )
        return self._unstable(SUSTAINED, f"{motion.name} keeps oscillating with {speed}")

    def _shows_nothing(self) -> str:
        """Return why a session without an oscillation shows nothing of its loop, if so."""
        users = self.traces.users
        if (length_s := self.traces.duration_s) < th.SHORTEST_S:
            return f"{length_s:.2g} s are too short to judge, {th.SHORTEST_S:g} s at least"
        if unknown := ", ".join(found.motion.name for found in self.found if not found.known):
            return f"too little of the motion of {unknown} is known"
        if not any((user.state == COUPLED).any() for user in users):
            return "no user was ever coupled"
        if not any(np.abs(user.xd_m).max() > th.OSCILLATION_M_S for user in users):
            return f"no device moved faster than {th.OSCILLATION_M_S * 1e3:g} mm/s"
        return ""


def _quiet_words(found: list[Strength]) -> str:
    """Return why motion beyond the voluntary band is no oscillation, with its amount."""
    worst = max(found, key=lambda each: each.late_m_s)
    late, most = 1e3 * worst.late_m_s, 1e3 * worst.most_m_s
    limit = f"(limit {most:.3g} mm/s){', and decays' if late > most else ''}"
    return f"oscillation beyond the voluntary band is {late:.1f} mm/s at the end {limit}"


def passive(traces: SessionTraces, scenario: Scenario | None) -> bool:
    """Tell whether all ports of users are passive, and the server gave and holds no more than it
    took in: the energy of such a loop is bounded.
    """
    energies, server = user_energies(traces, scenario), traces.server
    if server is None or not energies or any(each.passive is not True for each in energies):
        return False
    taken, given, holds = server_sums(server)
    return bool((taken - given - holds >= -tolerance(taken) - tolerance(holds)).all())


def _positions(traces: SessionTraces) -> Iterator[tuple[str, Array, Array]]:
    """Yield what has a position, its positions [m], and their times [s]."""
    for user in traces.users:
        yield f"{user.name}'s device", user.x_m, user.time_s
    if (server := traces.server) is None:
        return
    touched = np.any([touching(server, i) for i in range(len(server.users))], axis=0)
    latest_s = np.maximum.accumulate(np.where(touched, server.time_s, -np.inf))
    held = ~(server.time_s - latest_s >= th.SETTLE_S)  # else it coasts
    held |= ~np.isfinite(server.x_o).all(axis=-1)
    yield "the object", server.x_o[held], server.time_s[held]
    for name, x_s, state in zip(server.users, server.x_s, server.state, strict=True):
        present = state > 0
        yield f"{name}'s avatar", x_s[present], server.time_s[present]
