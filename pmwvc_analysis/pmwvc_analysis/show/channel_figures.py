# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of what is between the users: energy of the channel, network, timing of the loops."""

from typing import Any

import numpy as np

from pmwvc_analysis.judge.energy import Balance, UserEnergy, user_energies
from pmwvc_analysis.recording.losses import DROPPED, LOST
from pmwvc_analysis.show import style
from pmwvc_analysis.show.text import quantity
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.scenario import Scenario
from pmwvc_core.simulation.traces import FateTraces, SessionTraces


def energy(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw the energy balances of every user, one row each, violations hatched."""
    balances = user_energies(traces)
    if not balances:
        return None
    figure, rows = style.canvas(
        len(balances),
        title=style.title("Energy in less energy out", scenario),
        note=style.note(traces, scenario),
    )
    colours = style.colours(traces)
    largest = max(float(np.abs(b.balance_j).max()) for e in balances for _, b, _ in _lines(e))
    unit, scale = ("J", 1.0) if largest >= 1.0 else ("mJ", 1e3)
    for axes, entry in zip(rows, balances, strict=True):
        for label, balance, dashes in _lines(entry):
            axes.plot(
                balance.time_s,
                balance.balance_j * scale,
                color=colours[entry.name],
                ls=dashes,
                label=label,
            )
            style.shade(
                axes,
                style.spans(balance.violated, balance.time_s, join_s=0.1),
                label=f"{label}:\nmore out than in",
            )
            _mark_minimum(axes, balance, scale)
        axes.axhline(0.0, color=style.OBJECT, lw=0.9)
        axes.set_title(entry.name, color=colours[entry.name], fontweight="bold")
        axes.set_ylabel(f"balance [{unit}]")
        style.legend(axes)
    rows[-1].set_xlabel("time [s]")
    return figure


def _lines(entry: UserEnergy) -> list[tuple[str, Balance, str]]:
    if entry.up is None or entry.down is None:
        return [("both ways", entry.joint, "-")]
    return [("up, to the object", entry.up, "-"), ("down, to the hand", entry.down, "--")]


def _mark_minimum(axes: Any, balance: Balance, scale: float) -> None:
    if balance.passive or balance.minimum_time_s is None:
        return
    place = (balance.minimum_time_s, balance.minimum_j * scale)
    axes.plot(*place, marker="v", color=style.ALARM, ms=7)
    axes.annotate(
        quantity(balance.minimum_j, "J"),
        place,
        xytext=(-8, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        color=style.ALARM,
        fontsize=9,
        fontweight="bold",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
    )


def network(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw the delay of every packet and what became of the others, one row per link."""
    names = sorted(traces.fates, key=lambda name: (name.rpartition("/")[0], name.endswith("down")))
    links = {name: traces.fates[name] for name in names if len(traces.fates[name].number)}
    if not links:
        return None
    figure, rows = style.canvas(
        len(links),
        title=style.title("Packet delay and loss", scenario),
        note=style.note(traces, scenario),
        row_in=1.7,
    )
    colours = style.colours(traces)
    zeros = traces.metadata.get("fate_zero_ns", {})
    for axes, (name, fates) in zip(rows, links.items(), strict=True):
        user, _, way = name.rpartition("/")
        time_s = (fates.time_in_ns - zeros.get(name, 0)) * 1e-9
        _draw_link(axes, fates, time_s, colours.get(user, style.OBJECT))
        lost = int((fates.fate == LOST).sum())
        axes.set_title(f"{user}, way {way}: {len(fates.number)} packets, {lost} lost")
        axes.set_ylabel("delay [ms]")
        style.legend(axes)
    rows[-1].set_xlabel("time [s]")
    return figure


def _draw_link(axes: Any, fates: FateTraces, time_s: Array, tint: str) -> None:
    out = fates.time_out_ns > 0
    delay = (fates.time_out_ns - fates.time_in_ns)[out] * 1e-6
    axes.plot(
        time_s[out],
        delay,
        ls="",
        marker=".",
        ms=2.5,
        color=tint,
        label="delivered",
        rasterized=True,
    )
    top = max(1.0, 1.15 * float(delay.max(initial=0.0)))
    axes.set_ylim(-0.14 * top, top)
    for label, kinds, marker in (("lost", (LOST,), "x"), ("dropped", DROPPED, "+")):
        rows = np.isin(fates.fate, kinds)
        if rows.any():
            level = np.full(int(rows.sum()), -0.07 * top)
            axes.plot(
                time_s[rows], level, ls="", marker=marker, ms=5, color=style.ALARM, label=label
            )


def loop(traces: SessionTraces, scenario: Scenario | None) -> Any:
    """Draw how late the ticks of the force loops were, over time and how often."""
    users = [user for user in traces.users if user.lateness_s.any()]
    if not users:
        return None
    figure, (over_time, often) = style.canvas(
        2,
        title=style.title("Lateness of the force loop", scenario),
        note=style.note(traces, scenario),
        share="none",
    )
    colours = style.colours(traces)
    largest = max(float(user.lateness_s.max()) for user in users) * 1e6
    bins = np.geomspace(1.0, max(10.0, 1.05 * largest), 90)
    for user, marker in zip(users, "os^vDP*X", strict=False):
        late = np.clip(user.lateness_s * 1e6, 1.0, None)
        over_time.plot(
            user.time_s,
            late,
            ls="",
            marker=".",
            ms=1.5,
            alpha=0.5,
            color=colours[user.name],
            label=user.name,
            rasterized=True,
        )
        counts, _ = np.histogram(late, bins)
        median, most = np.percentile(late, (50, 99))
        label = f"{user.name}: median {median:.0f} us, 99 % below {most:.0f} us"
        centres = np.sqrt(bins[1:] * bins[:-1])
        often.plot(
            centres,
            counts,
            drawstyle="steps-mid",
            marker=marker,
            markevery=10,
            ms=4,
            color=colours[user.name],
            label=label,
        )
    over_time.set(yscale="log", xlabel="time [s]", ylabel="lateness [us]")
    often.set(xscale="log", yscale="log", xlabel="lateness [us]", ylabel="ticks")
    over_time.legend(
        loc="upper left", bbox_to_anchor=(1.005, 1.02), markerscale=6, borderaxespad=0.0
    )
    often.legend(loc="upper left")
    often.set_ylim(0.7, 40.0 * often.get_ylim()[1])  # room for the legend
    return figure
