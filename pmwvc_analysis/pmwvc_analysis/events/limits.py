# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits that took over in a session: of safety, and of a black box by its server port.

Safety: faults, braking for speed, forces limited again and again. A compensation of a black box
that shortens a returning wave from v = u - sqrt(2/b) F to v' takes energy from the user, and moves
the device away from its avatar; a port that learns repays that::

    energy_j   = sum (|v|^2 - |v'|^2) T_VE/2
    position_m = largest |sum (u + v' - (2b)^(1/2) xd) T_VE (2 b_m)^(-1/2)|

The environment is lost where this displacement is, for a whole second, more than 2 mm and more
than half of the way of the device so far: most of its depth is not the environment's.

Equations: docs/theory.md 5.10.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.events.nodes import COUPLED, FAULT, limited, unbraked
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.sums import begins, spans
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array, root
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces
from pmwvc_core.wave.impedance import WavePort
from pmwvc_core.words import count, quantity

RETURN = "soft start"
SPEED = ("faster than", RETURN)  # reasons that are the motion's and not the network's


class Withheld(NamedTuple):
    """Energy that the port withheld from one user, and the displacement by it."""

    energy_j: float
    position_m: float
    first_s: float  # time of the first wave that was shortened
    lost_s: float | None  # time from which the environment is lost; None: never


def withheld(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Withheld]:
    """Return the users whose environment was limited, as far as scenario and trace show it."""
    server = traces.server
    if scenario is None or server is None or not has_waves(scenario.controller):
        return {}
    known, found = {user.name: user for user in scenario.users}, dict[str, Withheld]()
    for user in traces.users if "withheld" in server.accounts else []:
        if user.name not in known or user.name not in server.users:
            continue
        index = server.users.index(user.name)
        port, there = WavePort(known[user.name].server_impedance), server.state[index] > 0
        u, v = np.nan_to_num(server.u_s[index]), np.nan_to_num(server.v_s[index])
        whole = np.asarray(port.v(u, np.nan_to_num(server.f_s[index])))
        half = 0.5 * server.periods_s
        kept_j = np.where(there, half * np.sum(whole**2 - v**2, axis=-1), 0.0)
        energy = float(kept_j.sum())
        if not energy > th.WITHHELD_J:
            continue
        off = u + v - port.u(np.nan_to_num(server.xd_s[index]), 0.0)
        off = np.where(there[:, np.newaxis], off / root(2.0 * known[user.name].impedance), 0.0)
        moved = np.cumsum(server.periods_s[:, np.newaxis] * off, axis=0)
        first_s = float(server.time_s[np.argmax(kept_j > 0.01 * th.WITHHELD_J)])
        joined = np.maximum.accumulate(np.where(begins(there), np.arange(len(there)), 0))
        off_m = _length(moved - moved[joined])  # an avatar of a later stay begins anew
        way_m = _length(user.x_m - user.x_m[0])[user.rows_at(server.time_s)]
        gone = off_m > np.maximum(th.LOST_M, th.LOST_SHARE * np.fmax.accumulate(way_m))
        lasting = (server.time_s[rows] for rows in spans(gone & there))
        lost_s = (float(each[0]) for each in lasting if each[-1] - each[0] >= th.LASTING_S)
        found[user.name] = Withheld(energy, float(off_m.max()), first_s, next(lost_s, None))
    return found


def lost(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return whose environment is lost, in words; empty if none is."""
    texts = (
        f"{name}: the environment is lost from {entry.lost_s:.2f} s on: the energy limit "
        f"of the server port displaced the device by {entry.position_m * 1e3:.1f} mm"
        for name, entry in withheld(traces, scenario).items()
        if entry.lost_s is not None
    )
    return next(texts, "")


def events(traces: SessionTraces, scenario: Scenario | None) -> list[dict[str, Any]]:
    """Return an event where the port first limits an environment, and one where it is lost."""
    found: list[dict[str, Any]] = []
    for name, entry in withheld(traces, scenario).items():
        whole = f"{_amount(entry.energy_j, entry.position_m)} by the end"
        times = [(entry.first_s, f"environment limited by the server port ({whole})")]
        if entry.lost_s is not None:
            times.append((entry.lost_s, "environment lost"))
        found += [{"time_s": t, "who": name, "kind": "environment", "what": w} for t, w in times]
    return found


def words(entry: dict[str, float]) -> str:
    """Return an entry of the summary in words."""
    return f"environment limited: {_amount(**entry)}"


def _amount(energy_j: float, position_m: float) -> str:
    return f"{quantity(energy_j, 'J')}, {position_m * 1e3:.3g} mm"


def _length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


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
        if braked >= th.OFTEN or ratio > th.OFTEN_RATIO:
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
        if ratio > th.OFTEN_RATIO and times >= th.OFTEN:
            limits = f"the force was limited {count(times, 'time')}"
            words = words or f"{user.name}: {limits}, {ratio:.0%} of the second half"
            size = np.linalg.norm(user.f_applied, axis=-1)
            at_most &= bool(np.mean(size[shortened] > th.LARGEST * size.max()) > 0.5)
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
            if speed_m_s < th.NEARLY * damped_m_s:
                continue
        if all(reason.startswith(SPEED) for reason in reasons):
            times += int(late[start])
            blocks_out += int(late[span].sum())
    return times, blocks_out / int(late.sum())
