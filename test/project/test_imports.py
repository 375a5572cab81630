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
    "account",
    "errors",
    "motion",
    "numeric",
    "params",
    "plugins",
    "transport",
    "wave",
}
CORE = {
    "errors": set(),
    "numeric": set(),
    "quantities": set(),
    "plural": set(),
    "account": {"numeric"},
    "motion": {"numeric"},
    "params": {"errors", "plugins"},
    "plugins": {"errors"},
    "traces": {"numeric"},
    "law": set(),
    "compiled": {"law"},
    "unrolled": {"law"},
    "wave": {"account", "errors", "numeric", "params"},
    "transport": {"account", "errors", "numeric", "params", "wave"},
    "plant": BASE | {"law"},
    "network": BASE,
    "master": BASE | {"law"},
    "server": BASE | {"law"},
    "controllers": BASE | {"law", "master", "server", "network"},
    "scenario": BASE | {"controllers", "network", "server"},
    "made": BASE | {"law", "plant", "master", "server", "controllers", "scenario", "frame"},
    "frame": BASE | {"law", "made", "plant", "master", "server", "controllers", "scenario"},
    "ends": BASE
    | {"law", "made", "frame", "plant", "master", "server", "controllers", "scenario", "unrolled"},
    "simulation": BASE
    | {
        "compiled",
        "law",
        "made",
        "master",
        "server",
        "plant",
        "network",
        "controllers",
        "scenario",
        "frame",
        "ends",
        "traces",
    },
}
# Below each room of the analysis: the rooms it may import beside itself.
ANALYSIS = {
    "traces": set(),
    "budget": {"traces"},
    "consistency": {"traces"},
    "events": {"traces"},
    "verdicts": {"traces", "budget", "events", "prediction", "recording"},
    "recording": set(),
    "replay": {"recording", "traces"},
    "charts": set(),
    "filters": set(),
    "maps": {"arrays", "models"},
    "transparency": {"arrays", "models"},
    "tune": {"budget", "models", "prediction", "transparency", "verdicts"},
    "compare": {
        "arrays", "budget", "models", "prediction", "recording", "traces", "transparency",
        "verdicts",
    },
    "figures": {
        "budget", "charts", "compare", "filters", "maps", "recording", "traces", "transparency",
        "verdicts",
    },
    "report": {"budget", "charts", "compare", "figures", "prediction", "traces", "verdicts"},
}  # fmt: skip
# Below each folder of the recording: what it may import of the recording; its files import all.
RECORDING = {"format": set()}
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


@pytest.mark.parametrize("package", PACKAGES)
def test_no_package_reaches_sideways(package):
    assert files_of(package)
    for file in files_of(package):
        ours = {name.split(".")[0] for name in imports_of(file) if name.startswith("pmwvc_")}
        assert ours - {package} <= PACKAGES[package], file


def test_only_the_recorder_of_the_analysis_needs_ros():
    for file in files_of("pmwvc_analysis"):
        roots = {name.split(".")[0] for name in imports_of(file)}
        if not file.name.startswith("recorder"):
            assert not roots & {"rclpy", "pmwvc_msgs"}, file


def test_the_core_touches_clock_system_and_ros_only_in_runtime():
    for file in files_of("pmwvc_core"):
        roots = {name.split(".")[0] for name in imports_of(file)}
        if "runtime" not in file.parts:
            assert not roots & CLOCKS, file


def test_the_blocks_of_the_core_do_not_import_each_other():
    for file in files_of("pmwvc_core"):
        block = file.relative_to(ROOT / "pmwvc_core" / "pmwvc_core").parts[0].removesuffix(".py")
        if block in ("runtime", "__init__"):
            continue
        for name in imports_of(file):
            if name.startswith("pmwvc_core."):
                assert name.split(".")[1] in CORE[block] | {block}, f"{file}: {name}"


@pytest.mark.parametrize("room", ANALYSIS)
def test_rooms_of_the_analysis_import_one_way(room):
    files = sorted((ROOT / "pmwvc_analysis" / "pmwvc_analysis" / room).glob("*.py"))
    assert len(files) > 1
    for file in files:
        for name in imports_of(file):
            if name.startswith("pmwvc_analysis."):
                assert name.split(".")[1] in ANALYSIS[room] | {room}, f"{file}: {name}"


@pytest.mark.parametrize("folder", RECORDING)
def test_folders_of_the_recording_import_one_way(folder):
    files = sorted((ROOT / "pmwvc_analysis/pmwvc_analysis/recording" / folder).glob("*.py"))
    assert len(files) > 1
    for file in files:
        for name in imports_of(file):
            if name.startswith("pmwvc_analysis."):
                assert name.split(".")[1] == "recording", f"{file}: {name}"
                assert name.split(".")[2] in RECORDING[folder] | {folder}, f"{file}: {name}"


def test_rooms_of_the_analysis_have_no_cycle():
    order = graphlib.TopologicalSorter(ANALYSIS).static_order()  # CycleError names the rooms
    assert set(order) >= set(ANALYSIS)


@pytest.mark.parametrize("package", [*PACKAGES, "pmwvc_bringup"])
def test_no_room_has_more_than_about_a_dozen_files(package):
    rooms = collections.Counter(
        file.parent for file in files_of(package) if file.name != "__init__.py"
    )
    assert rooms
    assert {str(room): count for room, count in rooms.items() if count > 14} == {}


@pytest.mark.parametrize(
    "file",
    [
        "pmwvc_master/pmwvc_master/loop.py",
        "pmwvc_server/pmwvc_server/loop.py",
        "pmwvc_core/pmwvc_core/simulation/user.py",
        "pmwvc_core/pmwvc_core/simulation/virtual_time.py",
    ],
)
def test_an_adapter_of_the_frame_protocol_is_thin(file):
    assert len((ROOT / file).read_text("utf-8").splitlines()) < 100


@pytest.mark.parametrize("package", [*PACKAGES, "pmwvc_bringup"])
def test_no_file_has_grown_into_several_subjects(package):
    for file in files_of(package):
        assert len(file.read_text().splitlines()) <= 320, file
