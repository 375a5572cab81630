# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports run one way only: between packages, the folders of the core, the analysis' rooms."""

import ast
import collections
import graphlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {
    "pmwvc_core": set(),
    "pmwvc_master": {"pmwvc_core", "pmwvc_msgs"},
    "pmwvc_server": {"pmwvc_core", "pmwvc_msgs"},
    "pmwvc_netem": {"pmwvc_core", "pmwvc_msgs"},
    "pmwvc_analysis": {"pmwvc_core", "pmwvc_msgs"},
    "pmwvc_view": {"pmwvc_core", "pmwvc_msgs", "pmwvc_analysis"},
}
# Below each folder of the core: what it may import of the core beside itself.
BASE = {
    *("account", "errors", "motion", "numeric", "params", "plugins", "quaternions", "transport"),
    "wave",
}
MADE = BASE | {"law", "plant", "master", "server", "controllers", "scenario", "frame"}
CORE = {
    "errors": set(),
    "numeric": set(),
    "quaternions": {"numeric"},
    "words": set(),
    "account": {"numeric"},
    "motion": {"numeric"},
    "params": {"errors", "plugins"},
    "plugins": {"errors"},
    "traces": {"numeric"},
    "law": set(),
    "compiled": {"law", "unrolled"},
    "unrolled": {"law"},
    "wave": {"account", "errors", "numeric", "params"},
    "transport": {"account", "errors", "numeric", "params", "quaternions", "wave"},
    "plant": BASE | {"law"},
    "network": BASE,
    "master": BASE | {"law"},
    "server": BASE | {"law", "scenes"},
    "scenes": {"errors", "numeric", "params", "plugins", "quaternions", "server"},
    "controllers": BASE | {"law", "master", "server", "network"},
    "scenario": BASE | {"controllers", "network", "server"},
    "made": MADE,
    "frame": (MADE - {"frame"}) | {"made"},
    "ends": MADE | {"made", "unrolled"},
    "simulation": MADE | {"compiled", "ends", "made", "network", "traces"},
}
# Below each room of the analysis: the rooms it may import beside itself.
ANALYSIS = {
    "traces": set(),
    "budget": {"traces"},
    "events": {"traces"},
    "verdicts": {"traces", "budget", "events", "prediction", "recording"},
    "recording": set(),
    "replay": {"recording", "traces"},
    "charts": set(),
    "maps": {"arrays", "models"},
    "transparency": {"arrays", "models"},
    "tune": {"budget", "models", "prediction", "transparency", "verdicts"},
    "compare": {
        "arrays", "budget", "models", "prediction", "recording", "traces", "transparency",
        "verdicts",
    },
    "figures": {
        "budget", "charts", "compare", "maps", "recording", "traces", "transparency",
        "verdicts",
    },
    "report": {
        "arrays", "budget", "charts", "compare", "figures", "prediction", "recording", "traces",
        "verdicts",
    },
}  # fmt: skip
# Below each folder of the recording: what it may import of the recording; its files import all.
CLOCKS = {"rclpy", "time", "threading", "os", "subprocess", "asyncio", "socket", "datetime"}


def imports_of(file):
    """Yield the dotted names a file imports."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{file}: relative import"
            yield node.module


def files_of(package):
    return sorted((ROOT / package / package).rglob("*.py"))


def parts_of(file, below):
    """Yield the parts, that follow the dotted name of a package, of what a file imports."""
    for name in imports_of(file):
        if name.startswith(f"{below}."):
            yield name.removeprefix(f"{below}.").split(".")


@pytest.mark.parametrize("package", PACKAGES)
def test_no_package_reaches_sideways(package):
    assert files_of(package)
    for file in files_of(package):
        ours = {name.split(".")[0] for name in imports_of(file) if name.startswith("pmwvc_")}
        assert ours - {package} <= PACKAGES[package], file


def test_ros_and_clocks_are_used_only_where_they_belong():
    for package, banned, exempt in (
        ("pmwvc_analysis", {"rclpy", "pmwvc_msgs"}, lambda file: file.name.startswith("recorder")),
        ("pmwvc_core", CLOCKS, lambda file: "runtime" in file.parts),
    ):
        for file in files_of(package):
            roots = {name.split(".")[0] for name in imports_of(file)}
            assert exempt(file) or not roots & banned, file


def test_the_blocks_of_the_core_do_not_import_each_other():
    for file in files_of("pmwvc_core"):
        block = file.relative_to(ROOT / "pmwvc_core" / "pmwvc_core").parts[0].removesuffix(".py")
        if block not in ("runtime", "__init__"):
            for first, *_ in parts_of(file, "pmwvc_core"):
                assert first in CORE[block] | {block}, file


@pytest.mark.parametrize("room", ANALYSIS)
def test_rooms_of_the_analysis_import_one_way(room):
    files = sorted((ROOT / "pmwvc_analysis" / "pmwvc_analysis" / room).glob("*.py"))
    assert len(files) > 1
    for file in files:
        for first, *_ in parts_of(file, "pmwvc_analysis"):
            assert first in ANALYSIS[room] | {room}, file
    order = graphlib.TopologicalSorter(ANALYSIS).static_order()  # CycleError names the rooms
    assert set(order) >= set(ANALYSIS)


@pytest.mark.parametrize("package", [*PACKAGES, "pmwvc_bringup"])
def test_no_room_has_more_than_about_a_dozen_files(package):
    files = [file for file in files_of(package) if file.name != "__init__.py"]
    rooms = collections.Counter(file.parent for file in files)
    assert rooms
    assert {str(room): count for room, count in rooms.items() if count > 14} == {}


@pytest.mark.parametrize(
    ("file", "adapters"),
    [
        ("pmwvc_master/pmwvc_master/loop.py", 1),
        ("pmwvc_server/pmwvc_server/loop.py", 1),
        ("pmwvc_core/pmwvc_core/simulation/virtual_time.py", 2),  # a user, the server
    ],
)
def test_an_adapter_of_the_frame_protocol_is_thin(file, adapters):
    assert len((ROOT / file).read_text("utf-8").splitlines()) < 100 * adapters
