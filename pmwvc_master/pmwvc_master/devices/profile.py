# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a model: a YAML file of ``profiles``, or a laboratory's own of the same form.

    max_force_n: {value: 12, source: "CHAI3D 3.2, CDeltaDevices.cpp"}

Every entry has a value in SI units and its source. What no source gives is left out: unknown.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from pmwvc_core.errors import PLUGIN_ERRORS, DeviceError, reason
from pmwvc_core.params.fields import Validated, fixed, specs

FOLDER = Path(__file__).parent / "profiles"
Vector3 = Sequence[float]  # in the axes of the device
ORIGIN = (0.0, 0.0, 0.0)
LIKE = "lines are like 'workspace_m: {value: 0.1, source: measured}'; there are"


@dataclass(frozen=True)
class Profile(Validated):
    """The entries of a file; None and empty ones are not known."""

    max_force_n: float | None = fixed(None, "> 0 N", "peak")
    continuous_force_n: float | None = fixed(None, "> 0 N", "for as long as one likes")
    max_torque_n_m: float | None = fixed(None, "> 0 N m", "peak")
    workspace_m: float | None = fixed(None, "> 0 m", "half extent")
    apparent_mass_kg: float | None = fixed(None, "> 0 kg", "at the handle")
    encoder_step_m: float | None = fixed(None, "> 0 m", "resolution of positions")
    centre_m: Vector3 = ORIGIN  # of the workspace
    turns: bool = False  # how the handle is turned is sensed
    types: Sequence[Any] = ()  # what the library or service calls the model
    joints: Sequence[Sequence[Any]] = ()  # rows of Denavit and Hartenberg
    sources: Mapping[str, str] = field(default_factory=dict)

    def lines(self) -> list[str]:
        """Return each entry with its source."""
        return [f"{name} = {getattr(self, name)} ({text})" for name, text in self.sources.items()]


def models_of(device: str) -> list[str]:
    """Return the models that a device has profiles of."""
    return sorted(file.stem for file in (FOLDER / device).glob("*.yaml"))


def profile_of(device: str, model: str) -> Profile:
    """Return the profile of a model, or that in a YAML file; DeviceError where it is none."""
    where, known = f"{device}.model = {model!r}", models_of(device)
    file = FOLDER / device / f"{model}.yaml" if model in known else Path(model).expanduser()
    if file.suffix not in (".yaml", ".yml"):
        ways = " or ".join([", ".join(known), "a YAML file with a profile"][not known :])
        raise DeviceError(f"{where}: must be {ways}")
    try:
        content, numbers = yaml.safe_load(file.read_text("utf-8")), specs(Profile)
        sources = {name: str(entry["source"]) for name, entry in content.items()}
        values = {name: entry["value"] for name, entry in content.items()}
        _, _, _ = map(float, values.get("centre_m", ORIGIN))
        values |= {n: numbers[n].converted(values[n]) for n in numbers if n in values}
        return Profile(**values, sources=sources)
    except PLUGIN_ERRORS as error:  # whatever is wrong with it
        text = f"{reason(error)}; {LIKE} {', '.join(Profile.__dataclass_fields__)}"
        raise DeviceError(f"{where}: {text}") from None
