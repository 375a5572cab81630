# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The safety limits that took over in a session: faults, braking for speed, forces limited again
and again.
"""

import numpy as np

from pmwvc_analysis.events.nodes import COUPLED, FAULT, limited, unbraked
from pmwvc_analysis.traces.reductions import begins, spans
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

RETURN = "soft start"
SPEED = ("faster than", RETURN)  # reasons that are the motion's and not the network's
NEARLY = 0.9  # of a speed limit, which is judged between two rows as well
LARGEST = 0.99  # of the largest force: a force that is as large as the limits allow


def taken_over(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return which safety layer took the force away, in words; empty when none did."""
    known = scenario.users if scenario else ()
    damped_m_s = {user.name: float(user.safety.damper_velocity) for user in known}
    for user in traces.users:
        faults = np.flatnonzero(user.state == FAULT)
        if len(faults):
            reason = user.reason[faults[0]] or "no reason given"
            return f"{user.name}: safety fault at {user.block_time_s[faults[0]]:.2f} s ({reason})"
        braked, ratio = _braked(user, traces.duration_s, damped_m_s.get(user.name, 0.0))
        if braked >= 3 or ratio > 0.05:
            return (
                f"{user.name}: for {ratio:.0%} of the second half the speed limit damped the "
                "device, or the force was ramping up after it"
            )
    return ""


def often_shortened(traces: SessionTraces) -> tuple[str, bool]:
    """Return whose force was limited again and again, in words; whether mostly at the largest."""
    words, at_most = "", True
    for user in traces.users:
        half, shortened = (user.time_s > traces.duration_s / 2) & unbraked(user), limited(user)
        ratio = float((shortened & half).sum() / max(half.sum(), 1))
        times = int(begins(shortened & half).sum())
        if ratio > 0.05 and times >= 3:
            limits = f"the force was limited {count(times, 'time')}"
            words = words or f"{user.name}: {limits}, {ratio:.0%} of the second half"
            size = np.linalg.norm(user.f_applied, axis=-1)
            at_most &= bool(np.mean(size[shortened] > LARGEST * size.max()) > 0.5)
    return words, at_most


def _braked(user: UserTraces, duration_s: float, damped_m_s: float) -> tuple[int, float]:
    """Return how often, in the second half, a coupled device was braked for its speed, and the
    ratio of that half in which it was braked or its force was returning from zero after it.

    Braking can be shorter than a block; what is seen then is the return alone. A device that was
    slower than the speed limit ``damped_m_s`` before it was not braked for its speed: the force
    returns after a silence that was as short.
    """
    late = user.block_time_s > duration_s / 2
    coupled = np.flatnonzero(user.state == COUPLED)
    if not late.any() or not len(coupled):
        return 0, 0.0
    blocks = np.arange(len(late))
    out = (user.state != COUPLED) & (blocks > coupled[0])
    times, blocks_out = 0, 0
    for span in spans(out):
        start, reasons = span.start, user.reason[span]
        if all(reason == RETURN for reason in reasons):  # of this block and the two before
            rows = slice(int(user.block_rows[max(start - 2, 0)]), int(user.block_ends[start]))
            speed_m_s = np.linalg.norm(user.xd_m[rows], axis=-1).max(initial=0.0)
            if speed_m_s < NEARLY * damped_m_s:
                continue
        if all(reason.startswith(SPEED) for reason in reasons):
            times += int(late[start])
            blocks_out += int(late[span].sum())
    return times, blocks_out / int(late.sum())
