# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A package of somebody else, as an installer leaves it in a folder of the Python path."""

from collections.abc import Mapping
from pathlib import Path


def install(folder: Path, module: str, source: str, points: Mapping[str, str]) -> None:
    """Write a module and the entry points of its package.

    ``points`` are texts like ``soft = "lab_soft:SOFT"`` by group of entry points.
    """
    (folder / f"{module}.py").write_text(source, "utf-8")
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    name = module.replace("_", "-")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = [f"[{group}]\n{point}\n" for group, point in points.items()]
    (info / "entry_points.txt").write_text("\n".join(lines).replace('"', ""))
