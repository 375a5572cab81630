# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits that took over in a session: of safety, and of a black box by its server port.

Safety: faults, braking for speed, forces limited again and again. A compensation of a black box
that shortens a returning wave from v = u - sqrt(2/b) F to v' takes energy from the user, and moves
the device away from its avatar; a port that learns repays that::

    energy_j   = sum (|v|^2 - |v'|^2) T_VE/2
    position_m = largest |sum (u + v' - (2b)^(1/2) xd) T_VE (2 b_m)^(-1/2)|

The environment is lost where at the end this displacement is more than 2 mm and more than half of
the way of the device: most of its depth is not the environment's.

Equations: docs/theory.md 5.10.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.events.nodes import COUPLED, FAULT, limited, unbraked
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.sums import begins, spans
from pmwvc_core.law.wave.wave import free_velocity, rooted, wave_v
from pmwvc_core.made.waves import through
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_core.words import count, quantity

FAST, RETURN = "faster than", "soft start"  # begins of reasons


class Withheld(NamedTuple):
    """Energy that the port withheld from one user, and the displacement by it."""

    energy_j: float
    position_m: float
    lost: bool  # whether the environment is lost


def withheld(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Withheld]:
    """Return the users whose environment was limited, as far as scenario and trace show it."""
    server, found = traces.server, dict[str, Withheld]()
    if scenario is None or server is None or "withheld" not in server.accounts:
        return found
    users = {user.name: user for user in traces.users}
    for known in (each for each in scenario.users if each.name in server.users):
        index = server.users.index(known.name)
        b, there = known.server_impedance, server.state[index] > 0
        signals = server.u_s, server.v_s, server.f_s, server.xd_s
        u, v, f, xd = (np.nan_to_num(each[index] * there[:, np.newaxis]) for each in signals)
        kept_j = 0.5 * server.periods_s * np.sum(through(wave_v, b, u, f) ** 2 - v**2, axis=-1)
        if known.name not in users or not kept_j.sum() > th.WITHHELD_J:
            continue
        off = 0.5 * through(free_velocity, known.impedance, u + v - through(rooted, b, xd))
        moved = np.cumsum(server.periods_s[:, np.newaxis] * off, axis=0)
        joined = np.maximum.accumulate(np.where(begins(there), np.arange(len(there)), 0))
        off_m = np.linalg.norm(moved - moved[joined], axis=-1)  # in a later stay it begins anew
        way_m = np.linalg.norm(users[known.name].x_m - users[known.name].x_m[0], axis=-1)
        lost = off_m[-1] > max(th.LOST_M, th.LOST_SHARE * float(np.nanmax(way_m)))
        found[known.name] = Withheld(float(kept_j.sum()), float(off_m.max()), bool(lost))
    return found


def words(entry: dict[str, Any]) -> str:
    """Return an entry of the summary in words."""
    amount = f"{quantity(entry['energy_j'], 'J')}, {quantity(entry['position_m'], 'm')}"
    return f"environment limited: {amount}"


def taken_over(traces: SessionTraces) -> tuple[str, float | None]:
    """Return which safety layer took the force away, in words, empty when none did, and since when
    it braked a device that was too fast [s]; None where it was no speed.
    """
    for user in traces.users:
        braked = spans(user.state != COUPLED)
        for fault in np.flatnonzero(user.state == FAULT)[:1]:
            reason, at_s = user.reason[fault] or "no reason given", user.block_time_s[fault]
            since = next(span.start for span in braked if span.stop > fault)
            since_s = float(user.block_time_s[since]) if reason.startswith(FAST) else None
            return f"{user.name}: safety fault at {at_s:.2f} s ({reason})", since_s
        late = user.block_time_s > traces.duration_s / 2
        fast = [s for s in braked if _for_speed(user.reason[s]) and late[s].any()]
        ratio = sum(int(late[span].sum()) for span in fast) / max(int(late.sum()), 1)
        if sum(late[span.start] for span in fast) >= th.OFTEN or ratio > th.OFTEN_RATIO:
            why = (
                f"{user.name}: for {ratio:.0%} of the second half the speed limit damped the "
                "device, or the force was ramping up after it"
            )
            return why, float(user.block_time_s[fast[0].start])
    return "", None


def _for_speed(reasons: list[str]) -> bool:
    """Tell whether a device was braked for its speed, and not because packets did not come."""
    fast = any(reason.startswith(FAST) for reason in reasons)
    return fast and all(reason.startswith((FAST, RETURN)) for reason in reasons)


def often_shortened(traces: SessionTraces, scenario: Scenario | None) -> tuple[str, bool]:
    """Return whose force or torque was limited again and again; whether mostly at the largest."""
    words, at_most = "", True
    for user in traces.users:
        half = (user.time_s > traces.duration_s / 2) & unbraked(user)
        for load, _, shortened, _, size in limited(user, scenario):
            ratio = float((shortened & half).sum() / max(half.sum(), 1))
            times = int(begins(shortened & half).sum())
            if ratio > th.OFTEN_RATIO and times >= th.OFTEN:
                limits = f"the {load} was limited {count(times, 'time')}"
                words = words or f"{user.name}: {limits}, {ratio:.0%} of the second half"
                at_most &= bool(np.mean(size[shortened] > th.LARGEST * size.max()) > 0.5)
    return words, at_most
