# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A symmetric positive definite matrix as the text of a parameter: ``30 2 0; 2 20 0; 0 0 25``.

Rows are separated by semicolons, entries by blanks or commas. Not here: what a matrix does
(:mod:`pmwvc_core.wave.impedance`).
"""

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import ParameterError

LARGEST_CONDITION = 1e6  # of the eigenvalues: beyond it, digits and time steps are lost
ASYMMETRY = 1e-9  # of the largest entry: digits lost in writing, made symmetric without a word


def matrix_of(text: str) -> NDArray[np.float64]:
    """Return the symmetric matrix ``(dof, dof)`` of a text; ParameterError with a wrong value."""
    if reason := _reason(text, None):
        raise ParameterError(f"{text!r}: must be {reason}")
    matrix = np.array(_rows(text))
    return np.asarray(0.5 * (matrix + matrix.T))


def matrix_conflicts(text: str, dof: int | None = None) -> list[str]:
    """Return the mistakes of a parameter ``impedance_matrix``; an empty text has none. The matrix
    has a row per axis, where their number ``dof`` is known.
    """
    reason = _reason(text, dof) if text.strip() else ""
    return [f"impedance_matrix = {text!r}: must be {reason}"] if reason else []


def _rows(text: str) -> list[list[float]]:
    return [[float(entry) for entry in row.replace(",", " ").split()] for row in text.split(";")]


def _reason(text: str, dof: int | None) -> str:
    """Return what the matrix would have to be and is not; "" where nothing is wrong."""
    try:
        rows = _rows(text)
    except ValueError:
        return "numbers, rows separated by ';'"
    size = len(rows)
    lengths = [len(row) for row in rows]
    if lengths != [size] * size:
        given = f"{size} rows of {', '.join(map(str, lengths))}"
        return f"square (it has {given} numbers)"
    if dof is not None and size != dof:
        return f"{dof} x {dof}, a row per axis (it is {size} x {size})"
    matrix = np.array(rows)
    if not np.isfinite(matrix).all():
        return "of finite numbers"
    gap = np.abs(matrix - matrix.T)
    if gap.max() > ASYMMETRY * np.abs(matrix).max():
        row, column = np.unravel_index(int(gap.argmax()), gap.shape)
        return f"symmetric (rows {row + 1} and {column + 1} differ)"
    values = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
    if values[0] <= 0.0:
        return f"positive definite (its smallest eigenvalue is {values[0]:.4g})"
    condition = values[-1] / values[0]
    if not condition <= LARGEST_CONDITION:
        return (
            f"of a condition number of at most {LARGEST_CONDITION:g} "
            f"(its eigenvalues are {values[0]:.4g} to {values[-1]:.4g})"
        )
    return ""
