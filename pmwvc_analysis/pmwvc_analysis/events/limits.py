# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits that took over in a session: of safety, and of a black box by its server port.

Safety: faults, braking for speed, forces limited again and again. A compensation of a black box
that shortens a returning wave from v = u - sqrt(2/b) F to v' takes energy from the user, and moves
the device away from its avatar; a port that learns repays that::

    energy_j   = sum (|v|^2 - |v'|^2) T_VE/2
    position_m = largest |sum (u + v' - (2b)^(1/2) xd) T_VE (2 b_m)^(-1/2)|

The environment is lost where this displacement is most of the device's depth. With the avatar's
travel p in its present contact and the distance s between device and avatar, of which q is the
displacement above, the environment and the delay of the link alone explain |p| + |s - q|. Means
over 0.5 s; lost where for a whole second

    |q| > 2 mm + 3 (|p| + |s - q|).

Equations: docs/theory.md 5.10.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.events.nodes import COUPLED, FAULT, limited, unbraked
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.sums import begins, spans
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array, root
from pmwvc_core.plural import count
from pmwvc_core.quantities import quantity
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.wave.impedance import WavePort

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
        lost_s = _lost_s(user, server, index, moved)
        found[user.name] = Withheld(energy, float(_length(moved).max()), first_s, lost_s)
    return found


def lost(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return whose environment is lost, in words; empty if none is."""
    for name, entry in withheld(traces, scenario).items():
        if entry.lost_s is not None:
            return (
                f"{name}: the environment is lost from {entry.lost_s:.2f} s on: the energy limit "
                f"of the server port displaced the device by {entry.position_m * 1e3:.1f} mm"
            )
    return ""


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


def _lost_s(user: UserTraces, server: ServerTraces, index: int, moved: Array) -> float | None:
    """Return when the environment is lost first; an avatar of a later stay begins anew."""
    there = server.state[index] > 0
    for stay in np.split(np.arange(len(there)), np.flatnonzero(begins(there))):
        rows = stay[there[stay]]
        if not len(rows):
            continue
        apart = user.x_m[user.rows_at(server.time_s[rows])] - server.x_s[index][rows]
        apart, own = apart - apart[0], moved[rows] - moved[rows[0]]
        way = (server.x_s[index] - server.x_o)[rows]  # relative to the object
        touching = np.asarray(server.contact[index])[rows]
        before = np.maximum(np.arange(len(rows)) - 1, 0)
        since = np.maximum.accumulate(np.where(begins(touching), before, 0))
        travel = np.where(touching[:, np.newaxis], way - way[since], 0.0)  # in this contact
        natural = _length(_mean(travel, server.period_s))
        natural = natural + _length(_mean(apart - own, server.period_s))
        gone = _length(_mean(own, server.period_s)) > th.LOST_M + th.LOST_RATIO * natural
        steps = max(1, round(th.LASTING_S / server.period_s))
        sums = np.concatenate([[0], np.cumsum(gone)])
        lasting = np.flatnonzero(sums[steps:] - sums[:-steps] == steps)
        if len(lasting):
            return float(server.time_s[rows[lasting[0]]])
    return None


def _mean(values: Array, period_s: float) -> Array:
    """Return the mean over the last 0.5 s; before that, of the pause before the first value."""
    rows = max(1, round(th.WITHHELD_S / period_s))
    sums = np.cumsum(values, axis=0)
    before = np.concatenate([np.zeros_like(sums[:rows]), sums[:-rows]])[: len(sums)]
    return np.asarray((sums - before) / rows)


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
