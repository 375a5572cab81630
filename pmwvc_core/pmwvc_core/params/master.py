# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the master port: wave impedance, rate drop, anti-aliasing filter, hold."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Is, IsNot, Validated, disordered, fixed, group, parameter
from pmwvc_core.params.port_filters import (
    BankParams,
    LocalModelParams,
    PositionParams,
    VelocityFilterParams,
)
from pmwvc_core.params.ports import DeadbandParams, matrix_conflicts

FILTER_KINDS = ("none", "first_order", "butterworth", "integrate_and_dump")


@dataclass(frozen=True)
class FilterParams(Validated):
    """Anti-aliasing filter of the outgoing wave. ``integrate_and_dump`` sends the mean over a
    frame: no cut-off, passive, of the shortest lag. A first-order filter has exactly one cut-off:
    ``pole_rad_s`` (what App. B calls f_c), ``cutoff_hz`` (-3 dB) or ``stop_hz`` (-20 dB). A
    Butterworth filter is designed from ``pass_hz``/``pass_db`` and ``stop_hz``/``stop_db`` (App.
    A).
    """

    kind: str = parameter(
        "integrate_and_dump", FILTER_KINDS, "which filter; integrate_and_dump: the mean of a frame"
    )
    pole_rad_s: float | None = parameter(None, "> 0 and <= 100000 rad/s", "first order: the pole")
    cutoff_hz: float | None = parameter(
        None, "> 0 and <= 10000 Hz", "first order: frequency of -3 dB"
    )
    stop_hz: float | None = parameter(
        None,
        "> 0 and <= 10000 Hz",
        "first order: frequency of -20 dB; Butterworth: edge of the stop band",
    )
    pass_hz: float = parameter(25.0, "> 0 and <= 10000 Hz", "Butterworth: edge of the pass band")
    pass_db: float = parameter(20.0, "> 0 and <= 200 dB", "Butterworth: attenuation at pass_hz")
    stop_db: float = parameter(40.0, "> 0 and <= 200 dB", "Butterworth: attenuation at stop_hz")
    meet: str = parameter("pass", ("pass", "stop"), "Butterworth: which edge is met exactly")
    discretisation: str = parameter(
        "bilinear", ("bilinear", "matched"), "Butterworth: from analogue to sampled"
    )

    # whether a packet is the mean of its frame: filter and rate drop in one
    means = Is("kind", "integrate_and_dump")
    is_on = IsNot("kind", "none")
    # whether the edges of the sampled Butterworth filter are those of a pre-warped one
    warps = Is("discretisation", "bilinear")

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
        "",
        "-",
        "symmetric positive definite matrix in place of b, like '30 2; 2 20' N s/m (empty: b)",
    )
    rate_drop: int = parameter(
        8,
        "1..1000",
        "force-loop ticks per packet, M; changes while running on the strict channel only",
    )
    tick_s: float = fixed(0.001, "0.0001..0.02 s", "period of the force loop, T_c")
    hold: str = parameter(
        "foh", ("zoh", "foh"), "expansion of the returning wave (foh: delayed first order)"
    )
    store_j: float = fixed(
        2e-3,
        "0..0.1 J",
        "energy that the playout of the returning wave may lend to late packets, once a session "
        "(strict channel)",
    )
    filter: FilterParams = group(FilterParams)
    velocity_filter: VelocityFilterParams = group(VelocityFilterParams)
    bank: BankParams = group(BankParams)
    local_model: LocalModelParams = group(LocalModelParams)
    position: PositionParams = group(PositionParams)
    deadband: DeadbandParams = group(DeadbandParams)

    ramps = Is("hold", "foh")  # to each returning wave, over the frame

    @property
    def frame_s(self) -> float:
        """Packet interval T_n = M T_c [s]."""
        return self.rate_drop * self.tick_s

    def conflicts(self) -> list[str]:
        """Check that the matrix is one."""
        return matrix_conflicts(self.impedance_matrix)
