# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the server: the shared object, how its algebraic loop is closed, and each user's
contact; and of the controllers to compare with, which both ends of a link share.

The defaults of these are what the rules of :mod:`pmwvc_core.controllers.record` give, with a
margin, for the default device, hand and contact at 24 ms of delay each way.
"""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, fixed, group, has, parameter
from pmwvc_core.params.ports import DeadbandParams, matrix_conflicts

BLACK_BOX = "unknown"  # the coupling that needs no equations
COUPLINGS = ("implicit", "one_step_delay", "one_frame_late", "unwrapped", BLACK_BOX)
INTEGRATORS = ("forward_euler", "backward_euler", "trapezoid")
COMPENSATIONS = ("none", "printed", "corrected", "ledger")
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
class BodyParams(Validated):
    """A box that turns and slips, on a table, held between pads."""

    friction: float = fixed(0.6, "0..5", "mu of pads and table, Coulomb")
    pad_m: float = fixed(0.01, "> 0 m", "radius of a pad, which touches at three points")
    width_m: float | None = fixed(None, "> 0 m", "along axis 1 (null: server.object_size_m)")
    height_m: float | None = fixed(None, "> 0 m", "along axis 2 (null: server.object_size_m)")
    gravity: float = fixed(9.81, "0..100 m/s^2", "acceleration by its weight")


@dataclass(frozen=True)
class ServerParams(Validated):
    """The virtual environment and its time step (theory: section 4)."""

    coupling: str = parameter(
        "implicit",
        COUPLINGS,
        "how the loop of wave and contact is solved; unknown by default but at cube and wall",
        group="pmwvc.couplings",
    )
    integrator: str = parameter(
        "backward_euler",
        INTEGRATORS,
        "position from velocity (one_step_delay, unwrapped, unknown)",
    )
    environment: str = fixed(
        "cube",
        "-",
        "cube: the shared object; wall: stands still; with coupling = unknown also hunt_crossley, "
        "each also as NAME_with_impedance, wall_with_slope, active_wall, body, mujoco, plug-ins",
    )
    period_s: float = parameter(
        0.008, "0.001..1 s", "time step, T_VE; changes while running on the strict channel only"
    )
    store_j: float = fixed(0.01, "0..0.1 J", "E0 of a playout, lent once (strict channel)")
    object_mass: float = parameter(2.0, "0.001..1000 kg", "mass of the shared object")
    object_damping: float = parameter(0.0, "0..100000 N s/m", "damping of the object to ground")
    object_size_m: float = fixed(0.06, "> 0 m", "edge of the cube; of a box, along axis 0")
    decoding: str = fixed(
        "secant",
        ("secant", "late"),
        "coupling unknown, no reported slope: decode along a slope learned from forces (secant), "
        "or with the previous step's force (late, App. C)",
    )
    compensation: str = fixed(
        "ledger",
        COMPENSATIONS,
        "coupling unknown: App. C Eq. 15 (printed), with its sign corrected and waves only "
        "shortened (corrected), or no more energy out than in (ledger)",
        group="pmwvc.compensations",
    )
    allowance_w: float = fixed(0.0, ">= 0 W", "ledger: largest power of an active environment")
    allowance_j: float = fixed(0.0, ">= 0 J", "ledger: largest energy of an active environment")
    tank_cap_j: float = fixed(0.25, ">= 0 J", "ledger: largest tank, no stored energy known")
    scene: str = fixed("", "-", "environment mujoco: the scene, an MJCF file")
    finger_m: float = fixed(0.01, "> 0 m", "radius of a user's finger in a scene")
    handles: str = fixed("", "-", "bodies of it that users hold, by commas, in place of fingers")
    settle: bool = fixed(False, "-", "let a scene fall for 2 s first, where bodies overlap")
    hunt_crossley: HuntCrossleyParams = group(HuntCrossleyParams)
    active_wall: ActiveWallParams = group(ActiveWallParams)
    body: BodyParams = group(BodyParams)
    lever_m: float = fixed(0.05, "0.001..10 m", "dof = 6: axes 4 to 6 are a turn [rad] times this")

    black_box = has("coupling", BLACK_BOX)
    learns = has("decoding", "secant")  # the slope of an environment that reports none

    def conflicts(self) -> list[str]:
        """Check what the environment has, and that the coupling knows enough of it."""
        text = f"environment = {self.environment!r}"
        if self.scene and self.environment in KNOWN:
            return [f"scene = {self.scene!r}: {text} has none; set server.environment = mujoco"]
        if self.environment in KNOWN or self.black_box:
            return []
        supported = f"{self.coupling} supports only {' and '.join(KNOWN)}"
        return [f"{text}: set server.coupling = unknown for it ({supported})"]


@dataclass(frozen=True)
class ContactParams(Validated):
    """One user's end at the server: wave impedance of that port and contact with the object."""

    impedance: float | None = parameter(
        None, "0.01..1000 N s/m", "wave impedance of the server port (null: that of the master)"
    )
    impedance_matrix: str = fixed("", "-", "positive definite matrix in its place, N s/m")
    contact: str = fixed(
        "grip",
        ("bilateral", "grip"),
        "bilateral: pulls and pushes; grip: pushes from the user's side",
    )
    contact_stiffness: float = parameter(500.0, "0..1e7 N/m", "contact stiffness K")
    contact_damping: float = parameter(10.0, "0..100000 N s/m", "contact damping B")
    gap_m: float = fixed(0.0, ">= 0 m", "distance from avatar to object at the start (grip, wall)")
    deadband: DeadbandParams = group(DeadbandParams)

    grips = has("contact", "grip")  # whether the contact only pushes, from the user's own side

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

    damping: float = parameter(9.0, ">= 0 N s/m", "local damping of the device's end")
    damping_max: float = parameter(
        25.0, ">= 0 N s/m", "largest at the device's end (rule: m/(10 T_c))"
    )
    fade_s: float = parameter(0.005, ">= 0 s", "fade-out of damping (0: at once)")
    drift_share: float = parameter(
        0.1, "0..1", "share of an avatar's offset repaid in a step, if energy allows (0: no)"
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
