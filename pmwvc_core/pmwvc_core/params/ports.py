# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of wave ports: what both ends have (the perceptual deadband of a sender, and an
impedance that is a symmetric positive definite matrix, as a text: ``30 2 0; 2 20 0; 0 0 25``), and
those of the master port: wave impedance, rate drop, anti-aliasing filter, hold.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import ParameterError, refusal
from pmwvc_core.params import port_filters
from pmwvc_core.params.fields import Validated, disordered, fixed, group, has, lacks, parameter

LARGEST_CONDITION = 1e6  # of the eigenvalues: beyond it, digits and time steps are lost
ASYMMETRY = 1e-9  # of the largest entry: digits lost in writing, made symmetric without a word


def matrix_of(text: str, dof: int | None = None) -> NDArray[np.float64]:
    """Return the matrix ``(dof, dof)`` of a text like ``30 2; 2 20``; else ParameterError."""
    try:
        matrix = np.array([row.replace(",", " ").split() for row in text.split(";")], dtype=float)
        symmetric = np.asarray(0.5 * (matrix + matrix.T))
        least, most = np.linalg.eigvalsh(symmetric)[[0, -1]]
        if (
            np.isfinite(matrix).all()
            and np.allclose(matrix, matrix.T, rtol=0.0, atol=ASYMMETRY * np.abs(matrix).max())
            and 0.0 < most <= LARGEST_CONDITION * least
            and len(matrix) == (dof or len(matrix))
        ):
            return symmetric
    except (ValueError, np.linalg.LinAlgError):  # no numbers, or not square
        pass
    raise ParameterError(
        f"{text!r}: must be {f'{dof} x {dof}' if dof else 'square'}, symmetric and positive "
        f"definite, of a condition number of at most {LARGEST_CONDITION:g}: numbers, a row per "
        "axis, rows separated by ';'"
    )


def matrix_conflicts(text: str, dof: int | None = None) -> list[str]:
    """Return the mistakes of a parameter ``impedance_matrix``; an empty text has none."""
    wrong = refusal(matrix_of, text, dof) if text.strip() else ""
    return [f"impedance_matrix = {wrong}"] if wrong else []


@dataclass(frozen=True)
class DeadbandParams(Validated):
    """Packets left out whose change is not felt (strict channel only)."""

    kind: str = parameter(
        "none", ("none", "weber"),
        "weber: no packet while the wave is within ratio; needs channel = strict",
    )  # fmt: skip
    ratio: float = parameter(0.1, "> 0 and <= 1", "difference not sent, of the last sent wave")
    longest_s: float = parameter(
        0.024, "> 0 and <= 1 s", "longest interval of sent packets, below safety.timeout_s"
    )

    is_on = lacks("kind", "none")  # whether packets are left out


def port_conflicts(port: Any, *, dof: int, strict: bool, timeout_s: float) -> list[str]:
    """Return the mistakes of a wave port; its receiver waits ``timeout_s`` [s]."""
    deadband = port.deadband
    found = matrix_conflicts(port.impedance_matrix, dof)
    if not strict and getattr(port, "rises", 1.0) > 1.0:
        found.append(f"contact_impedance = {port.contact_impedance:g}: needs channel = strict")
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


FILTER_KINDS = ("none", "first_order", "butterworth", "integrate_and_dump")


@dataclass(frozen=True)
class FilterParams(Validated):
    """Anti-aliasing filter of the outgoing wave. ``integrate_and_dump`` sends the mean over a
    frame: no cut-off, passive, of the shortest lag. A first-order filter has exactly one cut-off:
    ``pole_rad_s`` (what App. B calls f_c), ``cutoff_hz`` (-3 dB) or ``stop_hz`` (-20 dB). A
    Butterworth filter is designed from ``pass_hz``/``pass_db`` and ``stop_hz``/``stop_db`` (App.
    A).
    """

    kind: str = fixed(
        "integrate_and_dump", FILTER_KINDS, "which filter; integrate_and_dump: the mean of a frame"
    )
    pole_rad_s: float | None = fixed(None, "> 0 and <= 100000 rad/s", "first order: the pole")
    cutoff_hz: float | None = fixed(None, "> 0 and <= 10000 Hz", "first order: its -3 dB")
    stop_hz: float | None = fixed(
        None, "> 0 and <= 10000 Hz", "first order: its -20 dB; Butterworth: edge of the stop band"
    )
    pass_hz: float = fixed(25.0, "> 0 and <= 10000 Hz", "Butterworth: edge of the pass band")
    pass_db: float = fixed(20.0, "> 0 and <= 200 dB", "Butterworth: attenuation at pass_hz")
    stop_db: float = fixed(40.0, "> 0 and <= 200 dB", "Butterworth: attenuation at stop_hz")
    meet: str = fixed("pass", ("pass", "stop"), "Butterworth: which edge is met exactly")

    # whether a packet is the mean of its frame: filter and rate drop in one
    means = has("kind", "integrate_and_dump")
    is_on = lacks("kind", "none")

    def conflicts(self) -> list[str]:
        """Check that the cut-off is given once and used, and that Butterworth edges rise."""
        names = ("pole_rad_s", "cutoff_hz", "stop_hz")
        given = [name for name in names if getattr(self, name) is not None]
        if self.means and given not in ([], ["stop_hz"]):
            return [
                f"{given[0]} = {getattr(self, given[0])}: integrate_and_dump has no cut-off; set "
                f"kind = first_order, or {given[0]} = null"
            ]
        if self.kind == "first_order" and len(given) > 1:
            return [f"{' and '.join(given)} are given: a first-order filter takes one of them"]
        if self.kind == "butterworth":
            if self.stop_hz is None:
                return ["stop_hz = null: a Butterworth filter needs the edge of its stop band"]
            return disordered(self, ("pass_hz", "stop_hz"), ("pass_db", "stop_db"))[:1]
        return []


@dataclass(frozen=True)
class MasterParams(Validated):
    """The client end of the wave channel (App. A Fig. 1, App. B Fig. 1)."""

    impedance: float = parameter(25.0, "0.01..1000 N s/m", "wave impedance b")
    impedance_matrix: str = fixed(
        "", "-", "positive definite matrix in place of b, like '30 2; 2 20' N s/m (empty: b)"
    )
    contact_impedance: float | None = fixed(
        None, "0.01..1000 N s/m", "b in contact, >= impedance (null: the same; strict channel)"
    )
    rate_drop: int = parameter(
        8, "1..1000", "ticks per packet, M; changes while running on the strict channel only"
    )
    tick_s: float = fixed(0.001, "0.0001..0.02 s", "period of the force loop, T_c")
    hold: str = fixed("foh", ("zoh", "foh"), "returning wave in a frame (foh: delayed ramp)")
    store_j: float = fixed(0.01, "0..0.1 J", "E0 of the playout, lent once (strict channel)")
    filter: FilterParams = group(FilterParams)
    velocity_filter: port_filters.VelocityFilterParams = group(port_filters.VelocityFilterParams)
    bank: port_filters.BankParams = group(port_filters.BankParams)
    local_model: port_filters.LocalModelParams = group(port_filters.LocalModelParams)
    position: port_filters.PositionParams = group(port_filters.PositionParams)
    deadband: DeadbandParams = group(DeadbandParams)

    ramps = has("hold", "foh")  # to each returning wave, over the frame

    @property
    def frame_s(self) -> float:
        """Packet interval T_n = M T_c [s]."""
        return self.rate_drop * self.tick_s

    @property
    def rises(self) -> float:
        """How many times higher the impedance is in contact."""
        return 1.0 if self.contact_impedance is None else self.contact_impedance / self.impedance

    def conflicts(self) -> list[str]:
        """Check that the matrix is one, and that the impedance rises in contact."""
        found = matrix_conflicts(self.impedance_matrix)
        if self.rises > 1.0 and self.impedance_matrix.strip():
            found.append("contact_impedance: needs one b for all axes, no impedance_matrix")
        if self.rises < 1.0:
            found.append(f"contact_impedance = {self.contact_impedance:g}: must be >= impedance")
        return found


# What ``master.preset`` stands for (docs/tuning.md).
OF_PRESET = ("impedance", "contact_impedance", "position.adapts", "position.storage_j")
MASTERS = {
    name: {f"master.{each}": value for each, value in zip(OF_PRESET, values, strict=True)}
    for name, values in (
        ("even", (25.0, None, False, 0.0)),  # as in the dissertation
        ("light", (8.0, 12.0, True, 0.005)),  # to carry
        ("firm", (12.0, 25.0, True, 0.005)),  # to press on walls
    )
}
