# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of where the energy of a session is over time, and of what its controllers booked."""

import textwrap
from typing import Any

import numpy as np

from pmwvc_analysis.judge.budget import budget
from pmwvc_analysis.judge.budget_result import SERVER, Budget
from pmwvc_analysis.judge.budget_summary import worth_drawing
from pmwvc_analysis.judge.budget_words import GROUPS, account_words, words_of
from pmwvc_analysis.show import style
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.scenario import Scenario
from pmwvc_core.simulation.traces import SessionTraces

FILLS = {
    "devices": ("#0072B2", ""),
    "sampling and safety": ("#56B4E9", "///"),
    "filters and holds": ("#E69F00", ""),
    "links": ("#F0E442", "..."),
    "server's computation": ("#7A5195", "---"),
    "contacts": ("#D55E00", "\\\\\\"),
    "object": ("#CC79A7", ""),
    "controller": ("#009E73", "xxx"),
}
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
MOST_POINTS = 1500
LABEL = 34  # letters in a line of a legend


def whereabouts(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw what the hands gave and where it is, stacked; below, the parts that were active."""
    found = budget(traces, scenario)
    if found is None or len(found.time_s) < 2:
        return None
    active = [(entry.owner, entry.part) for entry in worth_drawing(found)]
    figure, rows = style.canvas(
        2 if active else 1,
        title=style.title("Where the energy of the hands is", scenario),
        note=style.note(traces, scenario),
        row_in=3.4,
    )
    kept = slice(None, None, max(1, len(found.time_s) // MOST_POINTS))
    time_s = found.time_s[kept]
    groups = {name: sums[kept] for name, sums in _groups(found).items()}
    unit, scale = _unit(np.concatenate([*groups.values(), _given(found)]))
    rises, falls = np.zeros(len(time_s)), np.zeros(len(time_s))
    for name, (tint, hatch) in FILLS.items():
        sums = groups.get(name, 0.0 * time_s)
        for base, part in ((rises, np.maximum(sums, 0.0)), (falls, np.minimum(sums, 0.0))):
            rows[0].fill_between(
                time_s,
                base * scale,
                (base + part) * scale,
                facecolor=tint,
                alpha=0.75,
                hatch=hatch,
                edgecolor="white",
                linewidth=0.0,
                label=name if base is rises and name in groups else None,
            )
            base += part
    rows[0].plot(time_s, _given(found)[kept] * scale, color=style.OBJECT, lw=1.8, label="hands")
    rows[0].axhline(0.0, color=style.OBJECT, lw=0.8)
    rows[0].set_ylabel(f"energy [{unit}]")
    style.legend(rows[0])
    if active:
        _draw_active(rows[1], found, active, kept)
    rows[-1].set_xlabel("time [s]")
    return figure


def _draw_active(axes: Any, found: Budget, active: list[tuple[str, str]], kept: slice) -> None:
    judged = {(owner, part): series for owner, part, series in found.judged()}
    unit, scale = _unit(np.concatenate([judged[each].sums for each in active]))
    for place, (owner, part) in enumerate(active):
        series = judged[owner, part]
        axes.plot(
            series.time_s[kept],
            series.sums[kept] * scale,
            color=style.colour(place),
            ls=DASHES[place],
            label=textwrap.fill(f"{owner}: {words_of(part)}", LABEL),
        )
    axes.axhline(0.0, color=style.OBJECT, lw=0.8)
    axes.set_title("Components that generated energy")
    axes.set_ylabel(f"taken in [{unit}]")
    style.legend(axes)


def _given(found: Budget) -> Array:
    return np.asarray(sum(found.hands.values()), dtype=float)


def _groups(found: Budget) -> dict[str, Array]:
    """Return the energies of all owners by group; groups that never hold any are left out."""
    sums: dict[str, Array] = {}
    for parts in found.parts.values():
        for part, series in parts.items():
            name = next(
                (name for name, members in GROUPS.items() if part in members), "controller"
            )
            sums[name] = sums.get(name, 0.0) + series
    smallest = 1e-4 * max(float(np.abs(series).max()) for series in sums.values())
    return {name: series for name, series in sums.items() if np.abs(series).max() > smallest}


def bookings(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw the energies that controllers booked themselves, a row per user and the server."""
    server = traces.server
    owners = [(user.name, user.block_time_s, user.accounts) for user in traces.users]
    if server is not None:
        owners.append((SERVER, server.time_s, server.accounts))
    owners = [owner for owner in owners if owner[2]]
    if not owners:
        return None
    figure, rows = style.canvas(
        len(owners),
        title=style.title("Energies that the controller booked", scenario),
        note=style.note(traces, scenario),
    )
    colours = style.colours(traces) | {SERVER: style.OBJECT}
    for axes, (name, time_s, accounts) in zip(rows, owners, strict=True):
        unit, scale = _unit(np.concatenate(list(accounts.values())))
        for place, (account, sums) in enumerate(accounts.items()):
            axes.plot(
                time_s,
                sums * scale,
                color=style.colour(place),
                ls=DASHES[place % len(DASHES)],
                label=textwrap.fill(account_words(account), LABEL),
            )
        axes.axhline(0.0, color=style.OBJECT, lw=0.8)
        axes.set_title(name, color=colours[name], fontweight="bold")
        axes.set_ylabel(f"energy [{unit}]")
        style.legend(axes)
    rows[-1].set_xlabel("time [s]")
    return figure


def _unit(values: Array) -> tuple[str, float]:
    """Return the unit in which values are read best, and its factor."""
    return ("J", 1.0) if np.nanmax(np.abs(values), initial=0.0) >= 1.0 else ("mJ", 1e3)
