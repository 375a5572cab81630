#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Presses on a stiff wall, again and again for ten minutes: what remains of the stored energy of
the position feedback, and the stiffness rendered: ``make presses`` writes ``docs/presses.md``.

One hand on the strict channel, 16 ms each way, follows a raised cosine through a grip of 375 N/m,
from 2 mm before the wall to the depth that takes the force. Every press makes and breaks contact.
E0 = 5 mJ is lent, K_p adapts.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from numpy.typing import NDArray

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_bringup import scenarios as files
from pmwvc_core.numeric import Array
from pmwvc_core.plant.hand import RecordedHand, recorded_motion
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Conditions, place_of
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURE = ROOT / "docs" / "presses.md", ROOT / "docs" / "images" / "presses.svg"
GAP_M, GRIP_N_M, LOAN_J, DELAY_S = 2e-3, 375.0, 5e-3, 0.016
LENT = ("master.position.adapts=true", f"master.position.storage_j={LOAN_J}")
LENGTH_S = 601.0
SHOWN = (1, 10, 100, 600)


@dataclass(frozen=True)
class Presses:
    """A run: wall [N/m], length of a press [s], force [N], settings."""

    stiffness: float
    press_s: float = 1.0
    force_n: float = 1.5
    settings: tuple[str, ...] = LENT


@dataclass(frozen=True)
class Found:
    """The result, press by press ``(press,)``.

    ``felt_n_m`` is the largest force over the depth of the device there, ``left_j`` what the node
    holds at the end of the press, ``least_j`` the least balance of the hand's port.
    """

    felt_n_m: Array
    left_j: Array
    least_j: float
    passive: bool | None


def scenario_of(run: Presses, duration_s: float, *more: str) -> Scenario:
    """Return the session of a run, with more settings."""
    texts = ["channel=strict", f"server.contact_stiffness={run.stiffness}", "task.kind=free"]
    texts += [f"server.gap_m={GAP_M}", f"link.delay_s={DELAY_S}"]
    texts += [f"operator.grip_stiffness={GRIP_N_M}", *run.settings, *more]
    return files.load("wall", settings_texts=texts, duration_s=duration_s)


def raised_cosine(run: Presses, tick_s: float) -> Array:
    """Return one press of the hand, from 2 mm before the wall and back [m]."""
    count = round(run.press_s / tick_s)
    depth_m = GAP_M + run.force_n / GRIP_N_M + run.force_n / run.stiffness
    return 0.5 * depth_m * (1.0 - np.cos(2.0 * np.pi * np.arange(count) / count))


def simulated(scenario: Scenario, motion: Array) -> SessionTraces:
    """Return the session of a hand that repeats a motion from where the device is [m]."""
    (user,) = scenario.users
    at, rows = place_of(user, scenario), motion[:, np.newaxis]
    hand = RecordedHand(0), recorded_motion(user.operator, rows, at.start, at.tick_s)
    traces = simulate_one(scenario, Conditions(hands={user.name: hand}))
    return traces


def pressed(run: Presses, duration_s: float = LENGTH_S) -> Found:
    """Return what is felt in every press of a run, and what is left after it."""
    scenario = scenario_of(run, duration_s, "operator.repeat=true")
    traces = simulated(scenario, raised_cosine(run, scenario.tick_s))
    (user,) = traces.users
    first = int(np.flatnonzero(user.f_h[:, 0])[0])
    ticks = round(run.press_s / user.tick_s)
    presses = (len(user.time_s) - first) // ticks
    rows = slice(first, first + presses * ticks)
    force = user.f_applied[rows, 0].reshape(presses, ticks)
    depth = (user.x_m[rows, 0] - user.x_m[0, 0] - GAP_M).reshape(presses, ticks)
    deepest: NDArray[np.intp] = np.argmax(force, axis=1)
    each = np.arange(presses)
    ends_s = user.time_s[first] + run.press_s * (each + 1)
    left = user.accounts["node"][np.searchsorted(user.block_time_s, ends_s) - 1]
    (entry,) = user_energies(traces, scenario)
    felt = force[each, deepest] / depth[each, deepest]
    return Found(felt, left, entry.joint.minimum_j, entry.passive)


RUNS = (
    Presses(500.0),
    Presses(1000.0),
    Presses(500.0, press_s=2.5),
    Presses(1000.0, press_s=2.5),
    Presses(1000.0, press_s=2.5, force_n=3.0),
    Presses(2000.0),
    Presses(2000.0, press_s=2.5),
    Presses(1000.0, press_s=2.5, settings=()),
    Presses(2000.0, press_s=2.5, settings=()),
)
COLUMNS = (
    *("wall [N/m]", "press", "presses", "stiffness in press 1, 10, 100, 600 or last [N/m]"),
    *("energy left [mJ]", "minimum energy balance [mJ]"),
)
TEXT = """# Presses

How long does the initial stored energy of position feedback last? {description}

`make presses` writes this page (some ten minutes of computing).

![Remaining stored energy, and rendered stiffness of the wall](images/presses.svg)

{table}

The hand port was passive in {passive} of {count} sessions. Slow presses take or return energy by
[theory, 17.17](theory.md#17-the-strict-channel). K_p adapts, so some energy remains up to
K = 2b/tau, the stiffness of the link: {link:.0f} N/m here. On a stiffer wall slow presses exhaust
it. From then on the feedback uses only the energy that each press returns, and the port stays
passive. Quick presses return more than they take.
"""


def row(run: Presses, found: Found) -> str:
    """Return a row of the table."""
    count = len(found.left_j)
    shown = sorted({min(number, count) for number in SHOWN})
    felt = ", ".join(f"{found.felt_n_m[number - 1]:.0f}" for number in shown)
    left = ", ".join(f"{1e3 * found.left_j[number - 1]:.1f}" for number in shown)
    cells = (
        f"{run.stiffness:.0f}",
        f"{run.force_n:g} N in {run.press_s:g} s",
        f"{count}",
        felt,
        left if run.settings else "without feedback",
        f"{1e3 * found.least_j:.2f}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Press, write page and picture."""
    with ProcessPoolExecutor(max_workers=2) as pool:
        results = list(zip(RUNS, pool.map(pressed, RUNS), strict=True))
    for run, found in results:
        print(row(run, found), flush=True)
    description = " ".join((__doc__ or "").split("\n\n")[1].split())
    tau_s = 2.0 * DELAY_S + 0.008
    b = float(scenario_of(RUNS[0], 1.0).users[0].master.impedance)
    head = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    text = TEXT.format(
        description=description,
        table="\n".join([*head, *(row(*each) for each in results)]),
        link=2.0 * b / tau_s,
        passive=sum(found.passive is True for _, found in results),
        count=len(results),
    )
    PAGE.write_text(text, "utf-8")
    draw(results)
    return 0


def draw(results: list[tuple[Presses, Found]]) -> None:
    """Write the picture."""
    mpl.rcParams.update({"font.size": 9, "svg.hashsalt": "presses", "axes.grid": True})
    figure, axes = plt.subplots(2, 1, figsize=(7.2, 5.6), sharex=True, layout="constrained")
    for run, found in results:
        if not run.settings:
            continue
        minutes = run.press_s * (1 + np.arange(len(found.left_j))) / 60.0
        label = f"{run.stiffness:.0f} N/m, {run.force_n:g} N in {run.press_s:g} s"
        axes[0].plot(minutes, 1e3 * found.left_j, label=label)
        axes[1].plot(minutes, found.felt_n_m / run.stiffness, label=label)
    axes[0].set(ylabel="left of the loan [mJ]", ylim=(0.0, 5.5))
    axes[1].set(ylabel="felt over true stiffness", ylim=(0.4, 1.1), xlabel="minutes of presses")
    axes[1].legend(ncols=2, loc="center right", bbox_to_anchor=(1.0, 0.45))
    figure.savefig(PICTURE, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
