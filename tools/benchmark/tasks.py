# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tasks of the benchmark, and the hands that a seed stands for.

``carry``    two hands grip a 2 kg cube and carry it to and fro
``wall``     one hand presses a wall of 2000 N/m and 10 N s/m, and lets go of it, time after time
``tapping``  a recorded person taps on that wall: even seeds an angle recorded while pressing a
             spring (two taps a second), odd ones of free shaking (seven a second)
``free``     one hand moves to and fro, 0.1 m, and touches nothing

The seed varies stiffness and damping of the hands by up to 25 %, the force of the grip and the
depth of a tap likewise, the distance by up to 30 %; all methods meet the same.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmark.methods import Settings
from pmwvc_bringup import scenarios as files
from pmwvc_core.scenario.scenario import Scenario

RECORDED = Path(__file__).resolve().parents[2] / "test" / "data"
LEVER_M = 0.075  # of the recorded angles
NEVER = "task.grip_s=1000"  # hands do not close: their targets alone move
GAP_M, DEPTH_M = 0.02, 0.02  # from the hand to the wall, and of its target in the wall
WALL = ("server.contact_stiffness=2000", "server.contact_damping=10")


class Task(NamedTuple):
    """A task: its scenario, what differs from that, and the usual distance of a move [m]."""

    scenario: str
    settings: Settings
    duration_s: float
    distance_m: float = 0.0


TASKS = {
    "carry": Task(
        "carry_16ms",
        (
            *("task.grip_s=0.5", "task.grip_rise_s=0.5", "task.move_s=1.5"),
            *("task.move_rise_s=2", "task.rest_s=0.5"),
        ),
        10.0,
        0.05,
    ),
    "wall": Task(
        "wall",
        (
            *("task.kind=carry", NEVER, "task.move_s=0.5", "task.move_rise_s=0.6"),
            *("task.rest_s=1.4", f"server.gap_m={GAP_M}", *WALL),
        ),
        12.0,
        GAP_M + DEPTH_M,
    ),
    "tapping": Task("wall", ("task.kind=free", "server.gap_m=0.002", *WALL), 10.0),
    "free": Task(
        "wall",
        (
            *("task.kind=carry", NEVER, "task.move_s=0.5", "task.move_rise_s=0.8"),
            *("task.rest_s=0.4", "server.gap_m=0.2", "device.workspace_m=1"),
        ),
        10.0,
        0.1,
    ),
}


def scenario_of(
    task: str, settings: Settings, network: str, seed: int, duration_s: float
) -> Scenario:
    """Return the scenario of a task on a network."""
    of = TASKS[task]
    texts = (*of.settings, *hands(task, seed), f"link.preset={network}", f"seed={seed}")
    return files.load(of.scenario, settings_texts=(*texts, *settings), duration_s=duration_s)


def hands(task: str, seed: int) -> Settings:
    """Return the settings of the hands, and of their motion."""
    spread = np.random.default_rng((seed, 1)).uniform(-1.0, 1.0, 4)
    stiffness, damping, force = (1.0 + 0.25 * spread[:3]).tolist()
    if task == "tapping":
        return (*_recorded(seed), f"operator.scale={LEVER_M * force:.6g}")
    distance_m = TASKS[task].distance_m
    if task != "wall":  # else the depth in the wall is the force, and the way to it stays
        distance_m *= 1.0 + 0.3 * float(spread[3])
    return (
        f"operator.stiffness={120.0 * stiffness:.6g}",
        f"operator.damping={15.0 * damping:.6g}",
        f"operator.squeeze={2.0 * force:.6g}",
        f"task.distance_m={distance_m:.6g}",
    )


def _recorded(seed: int) -> Settings:
    """Return the recording that a seed plays."""
    name, column = (("tue_hand.csv", "angle_rad"), ("tue_spring.csv", "angle_rad"))[seed % 2 == 0]
    return (
        *("operator.kind=playback_motion", f"operator.file={RECORDED / name}"),
        *(f"operator.columns={column}", "operator.rate_hz=2000", "operator.repeat=true"),
    )
