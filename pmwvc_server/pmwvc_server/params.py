# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Groups of parameters that only the server node has: parts of the masters', and a pause."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from pmwvc_core.params import MasterParams, SafetyParams, Validated
from pmwvc_core.params.fields import parameter
from pmwvc_core.params.matrix import matrix_conflicts


def _same_as(owner: type, name: str) -> Any:
    """Declare a field that is the same parameter as one of another dataclass."""
    field = next(field for field in dataclasses.fields(owner) if field.name == name)
    return dataclasses.field(default=field.default, metadata=field.metadata)


@dataclass(frozen=True)
class PortParams(Validated):
    """Parameters of a user's master that the server needs."""

    impedance: float = _same_as(MasterParams, "impedance")
    impedance_matrix: str = _same_as(MasterParams, "impedance_matrix")
    rate_drop: int = _same_as(MasterParams, "rate_drop")
    tick_s: float = _same_as(MasterParams, "tick_s")

    def conflicts(self) -> list[str]:
        """Check that the matrix is one."""
        return matrix_conflicts(self.impedance_matrix)

    @property
    def master(self) -> MasterParams:
        """A master with these parameters, the others at their defaults."""
        return MasterParams(**dataclasses.asdict(self))


@dataclass(frozen=True)
class WatchdogParams(Validated):
    """Times after which a user counts as silent, as gone, and as active: those of the masters."""

    timeout_s: float = _same_as(SafetyParams, "timeout_s")
    release_s: float = _same_as(SafetyParams, "release_s")
    soft_start_s: float = _same_as(SafetyParams, "soft_start_s")


@dataclass(frozen=True)
class PauseParams(Validated):
    """A parameter of the node alone, which no scenario has."""

    paused: bool = parameter(
        False, "-", "the object stands still, users are taken out and join anew afterwards"
    )
