# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of the links between the users: energy balance, packets."""

from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Balance
from pmwvc_analysis.budget.energy import UserEnergy, user_energies
from pmwvc_analysis.charts.chart import Band, Chart, Curve, Dots, Panel
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.recording.links import DROPPED
from pmwvc_analysis.traces.sums import runs
from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, SessionTraces
from pmwvc_core.words import count, quantity

JOIN_S = 0.1  # violations closer than that are marked as one
LOST_AT = -0.07  # of the largest delay: where packets that never came are drawn


def energy(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return the energy balances of every user, violations marked."""
    balances = user_energies(traces, scenario)
    if not balances:
        return None
    ways = [balance.balance_j for entry in balances for _, balance, _ in _ways(entry)]
    largest_j = np.nanmax(np.abs(np.concatenate(ways)), initial=0.0)
    unit, scale = ("J", 1.0) if largest_j >= 1.0 else ("mJ", 1e3)
    panels = []
    for entry in balances:
        tint = recorded.tint(traces, entry.name)
        lines, bands = [], recorded.bands(traces)
        for order, (label, balance, dash) in enumerate(_ways(entry)):
            period = 3.0 * traces.server.period_s if traces.server else 0.0  # steps come late
            time_s, sums = balance.time_s, balance.balance_j
            look: Any = tint, dash, 1.8 - 0.2 * order, period
            lines.append(Curve(label, time_s, sums * scale, *look))
            for first, last in runs(sums < balance.limit_j, time_s, join_s=JOIN_S):
                more = quantity(-float(sums[first : last + 1].min()), "J")
                between = float(time_s[first]), float(time_s[last])
                bands.append(Band(f"{label}: up to {more} more out than in", between))
        look = {"title": entry.name, "tint": tint, "height": 150.0, "with_zero": True}
        panels.append(Panel(f"balance [{unit}]", lines, bands=bands, **look))
    return Chart(
        "energy",
        "Energy balance of the links",
        "Energy that entered each direction less the energy that left it. A passive link stays at "
        "or above zero; where it does not, the time is shaded.",
        panels,
    )


def _ways(entry: UserEnergy) -> list[tuple[str, Balance, tuple[float, ...]]]:
    if entry.up is None or entry.down is None:
        return [("both directions", entry.joint, ())]
    return [("up, to the server", entry.up, ()), ("down, to the device", entry.down, (6, 4))]


def network(traces: SessionTraces, scenario: Scenario | None) -> Chart | None:
    """Return the delay of every packet and which were lost, a panel per link."""
    order = sorted(traces.fates, key=lambda name: (name.rpartition("/")[0], name.endswith("down")))
    links = {name: traces.fates[name] for name in order if len(traces.fates[name].number)}
    if not links:
        return None
    zeros = traces.metadata.get("fate_zero_ns", {})
    panels = []
    for name, fates in links.items():
        user, _, way = name.rpartition("/")
        time_s = (fates.time_in_ns - zeros.get(name, 0)) * 1e-9
        tint = recorded.tint(traces, user)
        lost = int((fates.fate == FateKind.LOST).sum())
        title = f"{user} {way}: {count(len(fates.number), 'packet')}, {lost} lost"
        look: Any = {"title": title, "tint": tint, "height": 90.0, "with_zero": True}
        panels.append(Panel("delay [ms]", dots=_packets(fates, time_s, tint), **look))
    return Chart(
        "network",
        "Packet delay and loss",
        "Each dot is a packet: the time at which it entered the link, and its delay. Marks below "
        "zero are packets that were lost (×) or dropped (+).",
        panels,
    )


def _packets(fates: FateTraces, time_s: Array, tint: str) -> list[Dots]:
    out = fates.time_out_ns > 0
    delay = (fates.time_out_ns - fates.time_in_ns)[out].astype(float) * 1e-6
    found = [Dots("delivered", time_s[out], delay, tint)]
    top = max(1.0, 1.15 * float(delay.max(initial=0.0)))
    for label, kinds, mark in (("lost", (FateKind.LOST,), "cross"), ("dropped", DROPPED, "plus")):
        rows = np.isin(fates.fate, kinds)
        if rows.any():
            level: Array = np.full(int(rows.sum()), LOST_AT * top)
            found.append(Dots(label, time_s[rows], level, "alarm", mark))
    return found
