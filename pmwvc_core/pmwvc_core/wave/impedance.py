# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A wave impedance that couples the axes: a symmetric positive definite matrix B.

It takes the place of the number b in the formulas of the port (:mod:`pmwvc_core.law.wave.wave`),
with 2/B = 2 B^-1 and the symmetric square root sqrt(B) = V diag(sqrt(lambda)) V^T, from B = V
diag(lambda) V^T. Then |u|^2 - |v|^2 = xd^T (2B) xd - 2 xd^T sqrt(2B) v = 2 F . xd. That needs
sqrt(2B)^T sqrt(2B) = 2B *and* sqrt(2B) = sqrt(2B)^T; a root by elements has neither.
Equations: docs/theory.md 6.1, 6.2, 6.3.
"""

import functools
import math
from typing import TypeAlias

import numpy as np

from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import ContactParams, MasterParams, SafetyParams, specs
from pmwvc_core.params.ports import matrix_of

ROUNDING = 1e-12
FORCE_N = float(specs(SafetyParams)["max_force"].high or math.inf)
VELOCITY_M_S = float(specs(SafetyParams)["fault_velocity"].high or math.inf)
DIRECT = 1000.0  # [m/s] up or [N] down: beyond any device, where there are no waves


class MatrixImpedance:
    """B, where a number may stand: its eigenvalues ``(dof,)`` [N s/m], and its principal axes, one
    per column ``(dof, dof)``.
    """

    __slots__ = ("axes", "values")

    def __init__(self, values: Array, axes: Array) -> None:
        self.values, self.axes = values, axes

    def with_values(self, values: Array) -> Array:
        """Return the matrix of other eigenvalues along the same axes ``(dof, dof)``."""
        upper = (self.axes * values) @ self.axes.T
        return np.asarray(0.5 * (upper + upper.T))

    @property
    def matrix(self) -> Array:
        """B itself [N s/m]."""
        return self.with_values(self.values)

    def __format__(self, spec: str) -> str:
        """Return the matrix in a line, as a parameter is written: ``[30 2; 2 20]``."""
        least = ROUNDING * float(self.values[-1])  # smaller entries are left by the eigenvalues
        shown = np.where(np.abs(self.matrix) < least, 0.0, self.matrix).tolist()
        rows = (" ".join(f"{entry:{spec}}" for entry in row) for row in shown)
        return f"[{'; '.join(rows)}]"


Impedance: TypeAlias = Value | MatrixImpedance


def impedance_of(port: MasterParams | ContactParams) -> Impedance:
    """Return the impedance that parameters name: the matrix where there is one, else the number;
    ParameterError where the text is no symmetric positive definite matrix.
    """
    matrix = port.impedance_matrix.strip()
    if matrix:
        return parsed(matrix)
    assert port.impedance is not None  # of a contact: server_impedance asks only where it is said
    return port.impedance


def server_impedance(own: ContactParams, master: MasterParams) -> Impedance:
    """Return the impedance of a server port: its own, or that of the user's master."""
    unsaid = own.impedance is None and not own.impedance_matrix.strip()
    return impedance_of(master if unsaid else own)


@functools.lru_cache(maxsize=256)
def parsed(text: str) -> Impedance:
    """Return the impedance that a text holds; for one axis a number."""
    matrix = matrix_of(text)
    if matrix.shape == (1, 1):
        return float(matrix[0, 0])
    values, axes = np.linalg.eigh(matrix)
    return MatrixImpedance(values, axes)


def first_axis(impedance: Impedance) -> float:
    """Return what a force along the first axis alone meets, 1/(B^-1)_00 [N s/m]."""
    if isinstance(impedance, MatrixImpedance):
        return 1.0 / float(impedance.with_values(1.0 / impedance.values)[0, 0])
    return float(impedance)


def transformation(master: Impedance, server: Impedance) -> float:
    """Return n^2 = e^T B_m^(-1/2) B_s B_m^(-1/2) e of two ends of a link, e the first axis: with
    numbers b_s/b_m. A contact at the server is n^2 times as compliant at the device.
    """
    if not isinstance(master, MatrixImpedance):
        first = server.matrix[0, 0] if isinstance(server, MatrixImpedance) else server
        return float(first) / float(master)
    row = master.with_values(1.0 / np.sqrt(master.values))[0]
    behind = server.matrix @ row if isinstance(server, MatrixImpedance) else server * row
    return float(behind @ row)


def smallest(impedance: Impedance) -> float:
    """Return the smallest eigenvalue, of a number itself [N s/m]."""
    return float(np.min(impedance.values if isinstance(impedance, MatrixImpedance) else impedance))


def largest(impedance: Impedance) -> float:
    """Return the largest eigenvalue, of a number itself [N s/m]."""
    return float(np.max(impedance.values if isinstance(impedance, MatrixImpedance) else impedance))


def largest_wave(impedance: Impedance, *, waves: bool) -> float:
    """Return the longest wave that can be meant at a port [sqrt(W)]: a coupled device renders at
    most ``FORCE_N`` and moves at most at ``VELOCITY_M_S``, and a passive server returns no more. u
    = (2B)^(-1/2) (F + B xd), so |u| <= F/sqrt(2 lambda_min) + xd sqrt(lambda_max/2). Without waves
    the longest of what is sent.
    """
    if not waves:
        return DIRECT
    least, most = smallest(impedance), largest(impedance)
    return FORCE_N / math.sqrt(2.0 * least) + VELOCITY_M_S * math.sqrt(0.5 * most)
