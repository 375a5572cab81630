# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a model: a YAML file of ``profiles``, or a laboratory's own of the same form.

    max_force_n: {value: 12, source: "CHAI3D 3.2, CDeltaDevices.cpp"}

Every entry has a value in SI units and its source. What no source gives is left out: unknown.
"""

import contextlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from pmwvc_core.errors import DeviceError

FOLDER = Path(__file__).parent / "profiles"
Vector3 = Sequence[float]  # in the axes of the device
ORIGIN = (0.0, 0.0, 0.0)


class Profile(NamedTuple):
    """The entries of a file; None and empty ones are not known."""

    sources: Mapping[str, str]  # by entry
    max_force_n: float | None = None  # peak
    continuous_force_n: float | None = None  # for as long as one likes
    max_torque_n_m: float | None = None
    workspace_m: float | None = None  # half extent
    apparent_mass_kg: float | None = None
    encoder_step_m: float | None = None
    centre_m: Vector3 = ORIGIN  # of the workspace
    types: Sequence[Any] = ()  # what the library or service calls the model
    joints: Sequence[Mapping[str, Any]] = ()  # rows of Denavit and Hartenberg

    def lines(self) -> list[str]:
        """Return each entry with its source."""
        return [f"{name} = {getattr(self, name)} ({text})" for name, text in self.sources.items()]


def models_of(device: str) -> list[str]:
    """Return the models that a device has profiles of."""
    return sorted(file.stem for file in (FOLDER / device).glob("*.yaml"))


def profile_of(device: str, model: str) -> Profile:
    """Return the profile of a model, or that in a YAML file; DeviceError with every mistake."""
    where, known = f"{device}.model = {model!r}", models_of(device)
    file = FOLDER / device / f"{model}.yaml" if model in known else Path(model).expanduser()
    if file.suffix not in (".yaml", ".yml"):
        raise DeviceError(f"{where}: must be {', '.join(known)} or a YAML file with a profile")
    try:
        content = yaml.safe_load(file.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise DeviceError(f"{where}: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise DeviceError(
            f"{where}: must have lines like 'workspace_m: {{value: 0.1, source: X}}'"
        )
    for entry in content.values():
        if isinstance(entry, dict) and isinstance(entry.get("value"), str):
            with contextlib.suppress(ValueError):  # YAML 1.1 reads 1e-5 as a text
                entry["value"] = float(entry["value"])
    if problems := [text for name in content if (text := _problem(name, content[name]))]:
        raise DeviceError(f"{where}: {'; '.join(problems)}")
    values = {name: entry["value"] for name, entry in content.items()}
    return Profile({name: entry["source"] for name, entry in content.items()}, **values)


def _problem(name: str, entry: Any) -> str:
    """Return what is wrong with an entry, or an empty text."""
    known = Profile._fields[1:]
    if name not in known:
        return f"{name}: must be one of {', '.join(known)}"
    if not isinstance(entry, dict) or set(entry) != {"value", "source"}:
        return f"{name} = {entry}: must be {{value: ..., source: ...}}"
    value = entry["value"]
    if name in ("types", "joints"):
        right, what = isinstance(value, list), "a list"
    elif name == "centre_m":
        right = isinstance(value, list) and len(value) == 3 and all(map(_finite, value))
        what = "3 numbers"
    else:
        right, what = _finite(value) and value > 0.0, "a number > 0"
    return "" if right else f"{name} = {value!r}: must be {what}"


def _finite(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)
