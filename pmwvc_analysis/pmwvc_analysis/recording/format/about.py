# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The metadata of a recording: source, scenario, seed, every parameter, versions.

Each is one MCAP metadata record of names and texts.
"""

import platform
from importlib import metadata

from pmwvc_core.scenario.scenario import Scenario

PACKAGES = ("pmwvc", "pmwvc_core", "rclpy", "numpy", "scipy", "mcap", "rosbags")


def about(scenario: Scenario | None, *, source: str) -> dict[str, dict[str, str]]:
    """Return the metadata records of a session by name."""
    session = {"source": source}
    records = {"session": session, "software": versions()}
    if scenario is not None:
        session |= {"scenario": scenario.name, "seed": str(scenario.seed)}
        records["parameters"] = {
            name: "null" if value is None else str(value)
            for name, value in scenario.flat().items()
        }
    return records


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that matter and are there."""
    found = {"python": platform.python_version(), "system": platform.platform()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return found
