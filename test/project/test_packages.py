# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packages are what an installed ROS 2 expects of them."""

import configparser
import importlib
import re
import sys
from importlib.metadata import distribution
from pathlib import Path

import pytest
from catkin_pkg.package import Package, parse_package
from project.test_imports import imports_of

ROOT = Path(__file__).resolve().parents[2]
EXECUTABLES = {
    "pmwvc_core": {},
    "pmwvc_master": {"master": "pmwvc_master.node:main"},
    "pmwvc_server": {"server": "pmwvc_server.node:main"},
    "pmwvc_netem": {"netem": "pmwvc_netem.node:main"},
    "pmwvc_analysis": {"recorder": "pmwvc_analysis.recorder_node:main"},
    "pmwvc_view": {"view": "pmwvc_view.node:main"},
    "pmwvc_bringup": {"pmwvc": "pmwvc_bringup.cli:main"},
}
PYTHON_PACKAGES = tuple(EXECUTABLES)
PACKAGES = (*PYTHON_PACKAGES, "pmwvc_msgs")
DEVICES = {
    "simulated": "pmwvc_master.devices.simulated:SimulatedDevice",
    "ros_topic": "pmwvc_master.devices.ros_topic:RosTopicDevice",
    "haply": "pmwvc_master.devices.haply:HaplyDevice",
    "lerobot": "pmwvc_master.devices.lerobot:LerobotDevice",
    "touch": "pmwvc_master.devices.touch:TouchDevice",
    "force_dimension": "pmwvc_master.devices.force_dimension:ForceDimensionDevice",
}
OPTIONAL = {"numba", "mujoco"}  # one module needs it, which says so where it is missing
ROSDEP_KEYS = {
    "jinja2": "python3-jinja2",
    "matplotlib": "python3-matplotlib",
    "PIL": "python3-pil",
    "mcap": "mcap-ros2-support",
    "numpy": "python3-numpy",
    "rich": "python3-rich",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "websockets": "python3-websockets",
    "yaml": "python3-yaml",
    "zstandard": "mcap-ros2-support",  # mcap needs it; it has no key of its own
}


def manifest(name: str) -> Package:
    return parse_package(ROOT / name)


def imports(folder: Path) -> set[str]:
    """Return the top-level names that the Python files below a folder import."""
    files = [file for file in folder.rglob("*.py") if file.name != "setup.py"]
    names = {name.split(".")[0] for file in files for name in imports_of(file)}
    return names - set(sys.stdlib_module_names)


@pytest.mark.parametrize("name", PACKAGES)
def test_manifest_is_valid(name: str) -> None:
    warnings: list[str] = []
    package = manifest(name)
    package.validate(warnings=warnings)
    assert warnings == []
    assert (package.name, package.package_format) == (name, 3)
    assert package.licenses == ["Apache-2.0"]
    emails = [maintainer.email for maintainer in package.maintainers]
    assert emails == ["maintainers@pmwvc.example"]
    kind = "ament_python" if name in PYTHON_PACKAGES else "ament_cmake"
    assert package.get_build_type() == kind


def test_all_packages_are_known_here_and_have_one_version() -> None:
    assert {path.parent.name for path in ROOT.glob("*/package.xml")} == set(PACKAGES)
    (version,) = {manifest(name).version for name in PACKAGES}
    assert {distribution(name).version for name in PYTHON_PACKAGES} == {version}


@pytest.mark.parametrize("name", PYTHON_PACKAGES)
def test_package_is_registered_and_installs_where_ros2_run_looks(name: str) -> None:
    assert (ROOT / name / "resource" / name).read_bytes() == b""
    settings = configparser.ConfigParser()
    settings.read(ROOT / name / "setup.cfg")
    assert settings["develop"]["script_dir"] == f"$base/lib/{name}"
    assert settings["install"]["install_scripts"] == f"$base/lib/{name}"
    share = Path(sys.prefix, "share")
    assert (share / "ament_index" / "resource_index" / "packages" / name).exists()
    assert (share / name / "package.xml").exists()


@pytest.mark.parametrize("name", PYTHON_PACKAGES)
def test_executables_are_the_ones_people_type(name: str) -> None:
    scripts = distribution(name).entry_points.select(group="console_scripts")
    assert {script.name: script.value for script in scripts} == EXECUTABLES[name]
    for script in EXECUTABLES[name]:
        assert Path(sys.prefix, "lib", name, script).exists()


def test_entry_points_name_something_callable() -> None:
    devices = distribution("pmwvc_master").entry_points.select(group="pmwvc.devices")
    assert {device.name: device.value for device in devices} == DEVICES
    for target in {
        *DEVICES.values(),
        *(t for each in EXECUTABLES.values() for t in each.values()),
    }:
        module, _, name = target.partition(":")
        assert callable(getattr(importlib.import_module(module), name)), target


@pytest.mark.parametrize("name", PYTHON_PACKAGES)
def test_every_import_is_declared_and_every_folder_a_package(name: str) -> None:
    declared = {dependency.name for dependency in manifest(name).exec_depends}
    modules = imports(ROOT / name) - {name} - OPTIONAL
    assert {ROSDEP_KEYS.get(module, module) for module in modules} <= declared
    folders = {file.parent for file in (ROOT / name / name).rglob("*.py")}
    assert [str(folder) for folder in folders if not (folder / "__init__.py").exists()] == []


@pytest.mark.parametrize("kind", ["launch", "config", "layouts"])
def test_installed_files_are_the_ones_in_the_source(kind: str) -> None:
    source = {file.name for file in (ROOT / "pmwvc_bringup" / kind).glob("*.*")}
    installed = Path(sys.prefix, "share", "pmwvc_bringup", kind)
    assert {file.name for file in installed.glob("*.*")} == source
    assert all(re.search(r"\.launch\.py$|\.(yaml|csv|xml|json|rviz)$", name) for name in source)
