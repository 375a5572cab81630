# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The budgets of lines: each room of the product has one, and it is only ever lowered.

A room is the folders that one subject has. Lines are those of its ``.py`` files, blank ones and
comments too. Whoever adds a line takes one out; whoever takes some out lowers the number.
"""

import re
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
LONGEST_FILE = 250  # lines
PAGES = 250_000  # bytes of docs/*.md
THRESHOLD = re.compile(r"^(?!ROUND|SAME|DRAWN)[A-Z_, ]+_(?:S|N|J|M|HZ|M_S|RATIO) = [0-9.]", re.M)


class Room(NamedTuple):
    """The folders and files of a subject below the root, its budget of lines, and the goal."""

    lines: int
    goal: int
    places: tuple[str, ...]


def inside(package: str, *names: str) -> tuple[str, ...]:
    return tuple(f"{package}/{package}/{name}" for name in names)


ROOMS = {
    "scenes, and handles that turn, drift, are scaled and uncoupled": Room(
        1_240,
        1_150,
        (
            *inside("pmwvc_core", "scenes", "params/behind.py", "server/turned.py"),
            *inside("pmwvc_master", "devices/mapped.py"),
        ),
    ),
    "laws": Room(5_925, 5_700, inside("pmwvc_core", "law")),
    "what makes, extends and compiles laws": Room(
        3_196,
        2_500,
        inside(
            "pmwvc_core",
            *("wave", "master", "server", "controllers", "made"),
            *("compiled.py", "unrolled.py", "simulation/bulk"),
        ),
    ),
    "links and packets": Room(
        2_195, 2_500, inside("pmwvc_core", "network", "transport", "quaternions.py")
    ),
    "sessions": Room(
        4_692,
        4_700,
        (
            *inside(
                "pmwvc_core", "params", "plant", "scenario", "frame", "ends", "simulation", "*.py"
            ),
            "pmwvc_core/*.py",
        ),
    ),
    "border to ROS": Room(1_574, 1_500, inside("pmwvc_core", "runtime")),
    "exact model": Room(
        3_393,
        3_500,
        inside(
            "pmwvc_analysis",
            *("models", "maps", "tune", "transparency", "prediction"),
            "arrays.py",
        ),
    ),
    "judge": Room(
        3_766,
        2_500,
        inside("pmwvc_analysis", "verdicts", "budget", "events", "traces"),
    ),
    "recordings": Room(
        3_063,
        3_000,
        (*inside("pmwvc_analysis", "recording", "replay", "*.py"), "pmwvc_analysis/*.py"),
    ),
    "figures and reports": Room(
        1_747, 2_400, inside("pmwvc_analysis", "charts", "compare", "figures", "report")
    ),
    "command line": Room(2_841, 3_200, ("pmwvc_bringup",)),
    "devices of vendors": Room(
        1_245,
        1_250,
        inside(
            "pmwvc_master",
            "devices/vendor.py",
            "devices/profile.py",
            "devices/plausible.py",
            "devices/check.py",
            "devices/touch.py",
            "devices/lerobot.py",
            "devices/haply.py",
            "devices/inverse_link.py",
            "devices/force_dimension.py",
            "devices/turn.py",
        ),
    ),
    "nodes": Room(1_902, 2_200, ("pmwvc_master", "pmwvc_server", "pmwvc_netem", "pmwvc_msgs")),
    "page": Room(2_853, 3_000, ("pmwvc_view",)),
}


def files_of(room: Room) -> list[Path]:
    found: list[Path] = []
    for place in room.places:
        found += ROOT.glob(place) if place.endswith(".py") else (ROOT / place).rglob("*.py")
    return [file for file in found if not {"build", "install"} & set(file.parts)]


def others_of(name: str) -> set[Path]:
    """Return the files of the rooms named before one: a file counts once."""
    before = list(ROOMS)[: list(ROOMS).index(name)]
    return {file for each in before for file in files_of(ROOMS[each])}


def lines_of(file: Path) -> int:
    return len(file.read_text("utf-8").splitlines())


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_stays_within_its_budget(name):
    room = ROOMS[name]
    lines = sum(lines_of(file) for file in files_of(room) if file not in others_of(name))
    assert lines <= room.lines, f"{name}: {lines} lines, {lines - room.lines} above the budget"


def test_every_file_of_the_product_is_in_one_room():
    counted = sorted({file for room in ROOMS.values() for file in files_of(room)})
    product = sorted(file for top in ROOT.glob("pmwvc_*") for file in top.rglob("*.py"))
    assert counted == product


def test_no_file_is_longer_than_the_longest():
    long = {file.name: lines_of(file) for room in ROOMS.values() for file in files_of(room)}
    assert max(long.values()) <= LONGEST_FILE, max(long, key=long.__getitem__)


def test_the_pages_stay_within_their_budget():
    assert sum(page.stat().st_size for page in (ROOT / "docs").glob("*.md")) <= PAGES


def test_every_number_that_judges_stands_in_the_table_of_thresholds():
    found = []
    for folder in ("verdicts", "budget", "events", "traces"):
        for file in (ROOT / "pmwvc_analysis/pmwvc_analysis" / folder).glob("*.py"):
            found += [file.name] * bool(THRESHOLD.search(file.read_text("utf-8")))
    assert sorted(set(found)) == ["thresholds.py"]
