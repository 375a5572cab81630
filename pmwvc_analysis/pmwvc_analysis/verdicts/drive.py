# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Who drives a motion, the loop or the hands.

While a force F_k is held a device goes from x_k to x_{k+1}, and its loop gives it the work
-F_k . (x_{k+1} - x_k). In motion beyond half a hertz, a passive loop takes more from all devices
together than it gives; once it may give back what masses and springs hold. One that keeps a
motion up gives, cycle after cycle, what the hands take out of it.

Equations: docs/theory.md 13.10.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.energy import server_sums, user_energies
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.felt import stops_s
from pmwvc_analysis.traces.sums import beyond
from pmwvc_analysis.verdicts.oscillation import Motion, shaking
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces
from pmwvc_core.words import quantity


class Drive(NamedTuple):
    """Work that the loop gave to all devices together in motion beyond half a hertz."""

    given_j: float
    moved_j: float  # work that went to and fro
    held_j: float  # most that masses and springs held of it
    free: bool  # whether a hand moves as it likes, a person or what is given, or met a stop
    steady: bool = False  # whether all that such hands do is push with a constant force
    made_j: float = 0.0  # what the links, or the server, gave out that did not go in

    @property
    def share(self) -> float:
        """What the loop gave, of the work that went to and fro, -1..1."""
        return self.given_j / self.moved_j if self.moved_j > 0.0 else 0.0

    @property
    def by_loop(self) -> bool:
        """Tell whether the loop drove the motion."""
        return self.share > th.DRIVES and self.given_j > th.CYCLES * self.held_j

    @property
    def by_hands(self) -> bool:
        """Tell whether hands that move as they like explain it: the loop did not drive it, and no
        more came out of links and server unseen than went to and fro. A steady force shakes
        nothing: it has to have given more than they did.
        """
        if self.steady:
            return self.free and self.share < -th.DRIVES and self.made_j <= -self.given_j
        return self.free and not self.by_loop and self.made_j <= self.moved_j


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
        force, x = (beyond(a, user.tick_s, th.REST_BAND_HZ) for a in (user.f_applied, user.x_m))
        given_j = -np.sum(force * np.diff(x, axis=0, append=x[-1:]), axis=-1)
        found.append(LoopWork(user, known[user.name].device.mass, force, x, given_j))
    return found if len(found) >= len(known) else []


def drive(
    traces: SessionTraces, scenario: Scenario | None, start_s: float, end_s: float,
    done: Sequence[LoopWork],
) -> Drive:  # fmt: skip
    """Return who drove the motion between two instants [s] by the :func:`works` of a session; no
    work where none are known, or ticks were not recorded.
    """
    if scenario is None:
        return UNKNOWN
    hands = [(user.operator, user.device.is_simulated) for user in scenario.users]
    kinds = {hand.kind for hand, simulated in hands if hand.is_free or not simulated}

    def inside(time_s: Array) -> Flags:
        return np.asarray((time_s >= start_s) & (time_s <= end_s))

    stopped = any(inside(stops_s(user, scenario)).any() for user in traces.users)
    free, steady = bool(kinds) or stopped, kinds == {"constant"} and not stopped
    unknown = UNKNOWN._replace(free=free, steady=steady)
    given_j = moved_j = held_j = 0.0
    for user, mass, force, x, work_j in done:
        rows = inside(user.time_s)
        whole = round((end_s - max(start_s, float(user.time_s[0]))) / user.tick_s) - 2
        if rows.sum() < max(whole, 2):
            return unknown
        given_j += float(work_j[rows].sum())
        moved_j += float(np.abs(work_j[rows]).sum())
        held_j += 0.5 * mass * _longest(user.xd_m[rows]) ** 2
        held_j += 0.5 * _longest(force[rows]) * _longest(x[rows])  # of a spring in between
    if not moved_j > 0.0:
        return unknown
    if (server := traces.server) is not None:
        fastest_m_s = _longest(server.xd_o[inside(server.time_s)])
        held_j += 0.5 * scenario.server.object_mass * fastest_m_s**2
    found = Drive(given_j, moved_j, held_j, free, steady)
    if not found.by_hands:
        return found

    def made_j(time_s: Array, balance_j: Array) -> float:
        known_j = balance_j[inside(time_s)]
        return float(known_j[0] - known_j[-1]) if len(known_j) else 0.0

    joints = (each.joint for each in user_energies(traces, scenario))
    hands_j = sum(made_j(joint.time_s, joint.balance_j) for joint in joints)
    behind_j = 0.0
    if server is not None:  # what it holds and turned to heat beyond what came in at its ports
        taken, given, holds = server_sums(server)
        behind_j = made_j(server.time_s, taken - given - holds)
    return found._replace(made_j=max(hands_j, behind_j))


def kept_driven(
    traces: SessionTraces, scenario: Scenario | None, moved: Sequence[Motion],
    done: Sequence[LoopWork],
) -> str:  # fmt: skip
    """Return which motion the loop drove at any time of a session, in words; empty: none."""
    for motion in (replace(each, band_hz=th.REST_BAND_HZ) for each in moved if done):
        for start_s, end_s in shaking(motion):
            found = drive(traces, scenario, start_s, end_s, done)
            if found.by_loop:
                during = f"from {start_s:.2f} to {end_s:.2f} s"
                given = f"the loop gave the hands {quantity(found.given_j, 'J')} in the meantime"
                return f"{motion.name} oscillated {during}, and {given}"
    return ""


def _longest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))
