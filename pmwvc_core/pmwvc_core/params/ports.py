# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What wave ports have at both ends: the perceptual deadband of a sender, and a wave impedance
that is a symmetric positive definite matrix, the text of a parameter: ``30 2 0; 2 20 0; 0 0 25``.

Not here: what a matrix does (:mod:`pmwvc_core.wave.impedance`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import ParameterError, refusal
from pmwvc_core.params.fields import IsNot, Validated, parameter

LARGEST_CONDITION = 1e6  # of the eigenvalues: beyond it, digits and time steps are lost
ASYMMETRY = 1e-9  # of the largest entry: digits lost in writing, made symmetric without a word


def matrix_of(text: str, dof: int | None = None) -> NDArray[np.float64]:
    """Return the matrix ``(dof, dof)`` of a text like ``30 2; 2 20``; else ParameterError."""
    must = f"{text!r}: must be"
    try:
        rows = [list(map(float, row.replace(",", " ").split())) for row in text.split(";")]
    except ValueError:
        raise ParameterError(f"{must} numbers, rows separated by ';'") from None
    size, lengths = len(rows), [len(row) for row in rows]
    if lengths != [size] * size:
        given = f"{size} rows of {', '.join(map(str, lengths))}"
        raise ParameterError(f"{must} square (it has {given} numbers)")
    if dof is not None and size != dof:
        raise ParameterError(f"{must} {dof} x {dof}, a row per axis (it is {size} x {size})")
    matrix = np.array(rows)
    if not np.isfinite(matrix).all():
        raise ParameterError(f"{must} of finite numbers")
    gap = np.abs(matrix - matrix.T)
    if gap.max() > ASYMMETRY * np.abs(matrix).max():
        first, second = np.unravel_index(int(gap.argmax()), gap.shape)
        raise ParameterError(f"{must} symmetric (rows {first + 1} and {second + 1} differ)")
    symmetric = np.asarray(0.5 * (matrix + matrix.T))
    values = np.linalg.eigvalsh(symmetric)
    if values[0] <= 0.0:
        raise ParameterError(
            f"{must} positive definite (its smallest eigenvalue is {values[0]:.4g})"
        )
    if not values[-1] / values[0] <= LARGEST_CONDITION:
        raise ParameterError(
            f"{must} of a condition number of at most {LARGEST_CONDITION:g} "
            f"(its eigenvalues are {values[0]:.4g} to {values[-1]:.4g})"
        )
    return symmetric


def matrix_conflicts(text: str, dof: int | None = None) -> list[str]:
    """Return the mistakes of a parameter ``impedance_matrix``; an empty text has none."""
    wrong = refusal(matrix_of, text, dof) if text.strip() else ""
    return [f"impedance_matrix = {wrong}"] if wrong else []


@dataclass(frozen=True)
class DeadbandParams(Validated):
    """Packets left out where nothing changed that could be felt (strict channel only)."""

    kind: str = parameter(
        "none",
        ("none", "weber"),
        "weber: no packet while the wave differs by less than ratio from the one sent last; "
        "needs channel = strict",
    )
    ratio: float = parameter(
        0.1, "> 0 and <= 1", "difference that is not felt, of the wave sent last"
    )
    longest_s: float = parameter(
        0.024,
        "> 0 and <= 1 s",
        "longest time that a packet stands for; below the silence time safety.timeout_s",
    )

    is_on = IsNot("kind", "none")  # whether packets are left out


def port_conflicts(port: Any, *, dof: int, strict: bool, timeout_s: float) -> list[str]:
    """Return the mistakes of a wave port (``MasterParams``, ``ContactParams``) in a session of so
    many axes, on the strict channel or not, whose receiver waits ``timeout_s`` [s].
    """
    deadband = port.deadband
    found = matrix_conflicts(port.impedance_matrix, dof)
    if deadband.is_on and not strict:
        found.append(
            f"deadband.kind = {deadband.kind}: needs channel = strict; a packet of the others "
            "stands for a fixed time"
        )
    elif deadband.is_on and deadband.longest_s >= timeout_s:
        found.append(
            f"deadband.longest_s = {deadband.longest_s:g}: must be < safety.timeout_s = "
            f"{timeout_s:g} s, or the receiver counts the sender as silent"
        )
    return found
