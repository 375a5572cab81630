# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the server: the shared object, how its algebraic loop is closed, and each user's
contact; and of the controllers to compare with, which both ends of a link share.

The defaults of these are what the rules of :mod:`pmwvc_core.controllers.record` give, with a
margin, for the default device, hand and contact at 24 ms of delay each way.
"""

from dataclasses import dataclass

from pmwvc_core.params.fields import Is, Validated, fixed, group, parameter
from pmwvc_core.params.ports import DeadbandParams, matrix_conflicts

COUPLINGS = ("implicit", "one_step_delay", "one_frame_late", "unwrapped", "unknown")
INTEGRATORS = ("forward_euler", "backward_euler", "trapezoid")
DECODINGS = ("secant", "late")
COMPENSATIONS = ("none", "printed", "corrected", "ledger")
BLACK_BOX = ("unknown",)  # couplings to a black-box environment
KNOWN = ("cube", "wall")  # environments whose equations every coupling has


@dataclass(frozen=True)
class HuntCrossleyParams(Validated):
    """Nonlinear contact, F = K d^n (1 + c d') with K = contact_stiffness in N/m^n."""

    exponent: float = fixed(1.5, "1..3", "n (Hertz, two spheres: 1.5)")
    damping: float = fixed(0.5, ">= 0 s/m", "c, damping per elastic force and speed")


@dataclass(frozen=True)
class ActiveWallParams(Validated):
    """A wall driven along axis 0, x = A sin(2 pi f t) from the first user on."""

    amplitude_m: float = fixed(0.01, "0..0.1 m", "amplitude A of the motion")
    frequency_hz: float = fixed(0.5, "0..10 Hz", "frequency f of the motion")


@dataclass(frozen=True)
class ServerParams(Validated):
    """The virtual environment and its time step (theory: section 4)."""

    coupling: str = parameter(
        "implicit",
        COUPLINGS,
        "how the algebraic loop between wave port and contact is solved",
        group="pmwvc.couplings",
    )
    integrator: str = parameter(
        "backward_euler",
        INTEGRATORS,
        "avatar position from its velocity (one_step_delay, unwrapped, unknown; the others fix "
        "it)",
    )
    environment: str = fixed(
        "cube",
        "-",
        "cube: the shared object; wall: a wall that does not move; with coupling = unknown also "
        "wall_with_slope, hunt_crossley, active_wall, or a plug-in by entry-point name",
    )
    period_s: float = parameter(
        0.008,
        "0.001..1 s",
        "time step of the environment, T_VE; changes while running on the strict channel only",
    )
    store_j: float = fixed(
        2e-3,
        "0..0.1 J",
        "energy that the playout of each user's wave may lend to late packets, once a session "
        "(strict channel)",
    )
    object_mass: float = parameter(2.0, "0.001..1000 kg", "mass of the shared object")
    object_damping: float = parameter(0.0, "0..100000 N s/m", "damping of the object to ground")
    object_size_m: float = fixed(0.06, "> 0 m", "edge length of the cube")
    decoding: str = fixed(
        "secant",
        DECODINGS,
        "unknown: force with which a wave is decoded where the environment reports no slope; "
        "secant: along a slope learned from its forces; late: the force of the step before "
        "(App. C)",
    )
    compensation: str = fixed(
        "ledger",
        COMPENSATIONS,
        "unknown: treatment of the energy of late decoding; printed: App. C Eq. 15; "
        "corrected: its sign corrected, credit kept, waves only shortened; ledger: return no more "
        "than was received",
        group="pmwvc.compensations",
    )
    allowance_w: float = fixed(
        0.0, ">= 0 W", "ledger: largest power that an active environment may deliver"
    )
    allowance_j: float = fixed(
        0.0, ">= 0 J", "ledger: largest energy that an active environment may deliver in total"
    )
    tank_cap_j: float = fixed(
        0.25,
        ">= 0 J",
        "ledger: energy kept for an environment that does not report how much it stores",
    )
    hunt_crossley: HuntCrossleyParams = group(HuntCrossleyParams)
    active_wall: ActiveWallParams = group(ActiveWallParams)

    # whether a port learns the slope of an environment that reports none
    learns = Is("decoding", "secant")

    def conflicts(self) -> list[str]:
        """Check that the coupling can do with what it knows of the environment."""
        if self.environment in KNOWN or self.coupling in BLACK_BOX:
            return []
        return [
            f"environment = {self.environment!r}: set server.coupling = unknown for it "
            f"({self.coupling} supports only {' and '.join(KNOWN)})"
        ]


@dataclass(frozen=True)
class ContactParams(Validated):
    """One user's end at the server: wave impedance of that port and contact with the object."""

    impedance: float | None = parameter(
        None,
        "0.01..1000 N s/m",
        "wave impedance of the server port (null: that of the user's master)",
    )
    impedance_matrix: str = fixed(
        "", "-", "symmetric positive definite matrix in place of that number, N s/m (empty: none)"
    )
    contact: str = fixed(
        "grip",
        ("bilateral", "grip"),
        "bilateral: spring and damper that pull and push; "
        "grip: from the user's own side, only pushing",
    )
    contact_stiffness: float = parameter(500.0, "0..1e7 N/m", "contact stiffness K")
    contact_damping: float = parameter(10.0, "0..100000 N s/m", "contact damping B")
    gap_m: float = fixed(
        0.0, ">= 0 m", "distance of the avatar from the object at the start (grip and wall)"
    )
    deadband: DeadbandParams = group(DeadbandParams)

    grips = Is("contact", "grip")  # whether the contact only pushes, from the user's own side

    def conflicts(self) -> list[str]:
        """Check that the matrix is valid and the impedance is given once."""
        if self.impedance_matrix.strip() and self.impedance is not None:
            return ["impedance and impedance_matrix are given: a server port takes one of them"]
        return matrix_conflicts(self.impedance_matrix)


@dataclass(frozen=True)
class VirtualCouplingParams(Validated):
    """Spring and damper between device and avatar, at both ends (Colgate 1995, Adams 1999)."""

    stiffness: float = parameter(300.0, "> 0 N/m", "stiffness of the coupling, K_c")
    damping: float = parameter(3.0, ">= 0 N s/m", "damping of the coupling, B_c")


@dataclass(frozen=True)
class TdpaParams(Validated):
    """Time-domain passivity observer and controller (Hannaford 2002, Ryu 2010)."""

    damping: float = parameter(
        9.0, ">= 0 N s/m", "local damping of the device's end, no part of the link"
    )
    damping_max: float = parameter(
        25.0, ">= 0 N s/m", "most damping that the device's end adds (rule: m/(10 T_c))"
    )
    fade_s: float = parameter(
        0.005, ">= 0 s", "time in which damping fades once it is not needed (0: at once)"
    )
    drift_share: float = parameter(
        0.1,
        "0..1",
        "share of the avatar's lag made up in a step, as far as energy allows (0: drifts)",
    )


@dataclass(frozen=True)
class PspmParams(Validated):
    """Passive set-position modulation (Lee and Huang 2010)."""

    stiffness: float = parameter(500.0, "> 0 N/m", "spring to the set point, K")
    damping: float = parameter(2.0, ">= 0 N s/m", "damping to ground, B (rule: > K T_c/2)")
    initial_j: float = parameter(0.02, ">= 0 J", "energy that each end starts with")
    cap_j: float = parameter(0.02, ">= 0 J", "energy above which the rest goes to the peer")


@dataclass(frozen=True)
class BaselineParams(Validated):
    """One group per controller that needs numbers of its own."""

    virtual_coupling: VirtualCouplingParams = group(VirtualCouplingParams)
    tdpa: TdpaParams = group(TdpaParams)
    pspm: PspmParams = group(PspmParams)
