# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of one user's side of the loop: the device, the hand on it, and the limits that guard
the hand.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from pmwvc_core.params.fields import Validated, disordered, fixed, group, has, lacks, parameter

OPERATOR_KINDS = (
    *("none", "constant", "sinusoid", "chirp", "hand", "remote"),
    *("playback_force", "playback_motion"),
)


@dataclass(frozen=True)
class DeviceParams(Validated):
    """The device, and its simulation: m x'' + b_hd x' = f_h - F_m."""

    plugin: str = fixed("simulated", "-", "device plug-in by entry-point name")
    mass: float = parameter(0.25, "> 0 kg", "apparent mass at the handle")
    damping: float = parameter(0.0, ">= 0 N s/m", "viscous damping of the device")
    friction: float = parameter(0.0, ">= 0 N", "Coulomb friction")
    encoder_step_m: float = parameter(0.0, ">= 0 m", "position resolution (0: exact)")
    velocity: str = parameter(
        "exact", ("exact", "euler"),
        "velocity: the state's, or differences of the measured position",
    )  # fmt: skip
    workspace_m: float = parameter(0.2, "> 0 m", "half extent of the workspace (mechanical stops)")
    scale: float = fixed(1.0, "0.1..10", "avatar's motion by the hand's; forces inversely")
    axes: str = fixed("", "-", "axes of a real device along x, y, z, like 'y -x z' (empty: usual)")
    offset_x_m: float = fixed(0.0, "-1..1 m", "position of the middle of a real device")
    offset_y_m: float = fixed(0.0, "-1..1 m", "likewise")
    offset_z_m: float = fixed(0.0, "-1..1 m", "likewise")
    clutch: int = fixed(0, "0..32", "button of the device that uncouples the hand (0: none)")

    is_simulated = has("plugin", "simulated")  # the device of the library, whose state is known
    differences = has("velocity", "euler")  # of measured positions

    def conflicts(self) -> list[str]:
        """Check the axes."""
        words = sorted(word.removeprefix("-") for word in self.axes.split())
        if words == list("xyz"[: len(words)]):
            return []
        return [f"axes = {self.axes!r}: must be x, y and z once each, like 'y -x z'"]


@dataclass(frozen=True)
class SafetyParams(Validated):
    """Limits between controller and device, in every control path; they are never off."""

    max_force: float = parameter(8.0, "> 0 and <= 20 N", "peak force (Touch 3.3, large devices 8)")
    max_torque: float = fixed(0.0, ">= 0 N m", "dof = 6: peak torque; 0: max_force server.lever_m")
    max_slew: float = parameter(2000.0, "1..20000 N/s", "fastest change of force")
    soft_start_s: float = fixed(0.5, "0.01..10 s", "force rises from zero over this time")
    damper_velocity: float = parameter(1.0, "> 0 and <= 10 m/s", "faster: only damping")
    fault_velocity: float = parameter(1.5, "> 0 and <= 20 m/s", "faster: no force any more")
    timeout_s: float = parameter(
        0.03, "> 0 and <= 10 s", "time without packets, at least three, until only damping"
    )
    release_s: float = parameter(
        5.0, "> 0 and <= 60 s", "time without packets until brake and damping end"
    )

    def conflicts(self) -> list[str]:
        """Check the order of the two speed limits."""
        return disordered(self, ("damper_velocity", "fault_velocity"))

    def torque_n_m(self, lever_m: float) -> float:
        """Return the peak torque [N m]: as given, or that of the peak force at the lever."""
        return self.max_torque or self.max_force * lever_m


class ServerTimes(NamedTuple):
    """Times of the server, one for all users: the longest of theirs [s]."""

    timeout_s: float
    release_s: float
    soft_start_s: float


def server_times(users: Iterable[SafetyParams]) -> ServerTimes:
    """Return when the server takes a user as silent and as gone, and when tasks begin."""
    each = list(users)
    return ServerTimes(
        *(max(float(getattr(user, name)) for user in each) for name in ServerTimes._fields)
    )


@dataclass(frozen=True)
class RemoteHandParams(Validated):
    """The arm of operator `remote` and its limits; its grip is that of any hand."""

    mass: float = parameter(0.4, "0.05..10 kg", "mass of the arm")
    damping: float = parameter(22.0, "0..200 N s/m", "damping of the arm")
    stiffness: float = parameter(300.0, "1..2000 N/m", "stiffness of the arm to its target")
    speed_m_s: float = parameter(0.5, "> 0 and <= 1 m/s", "fastest motion of the arm's target")
    reach_n: float = parameter(
        6.0, "> 0 and <= 20 N",
        "largest force of the arm's spring, which ends at reach_n / stiffness",
    )  # fmt: skip
    brake: float = parameter(5.0, "0..20 N s/m", "damping of a handle that is not held")


@dataclass(frozen=True)
class OperatorParams(Validated):
    """What pushes the device. Times count from the moment the user is coupled."""

    kind: str = parameter("hand", OPERATOR_KINDS, "what drives the device")
    force: float = parameter(1.0, "N", "constant, sinusoid, chirp: amplitude along +x, signed")
    frequency_hz: float = parameter(1.0, "0..400 Hz", "sinusoid: frequency; chirp: the first")
    frequency_end_hz: float = parameter(50.0, "0..400 Hz", "chirp: last frequency")
    sweep_s: float = parameter(20.0, "> 0 s", "chirp: duration of one sweep")
    mass: float = parameter(0.8, "> 0 kg", "hand: mass of the arm")
    damping: float = parameter(5.5, ">= 0 N s/m", "hand: damping of the arm towards its target")
    stiffness: float = parameter(30.0, ">= 0 N/m", "hand: stiffness of the arm to its target")
    grip_stiffness: float = parameter(375.0, ">= 0 N/m", "hand, remote: stiffness of the grip")
    grip_damping: float = parameter(7.9, ">= 0 N s/m", "hand, remote: damping of the grip")
    squeeze: float = parameter(1.0, ">= 0 N", "hand, remote: force that holds a gripped object")
    file: str = fixed("", "-", "playback: CSV or NPY")
    columns: str = fixed("", "-", "playback: columns by name or number (from 0), by commas")
    time_column: str = fixed("", "-", "playback: column of the time [s] (empty: rate_hz)")
    rate_hz: float = parameter(1000.0, "> 0 Hz", "playback: rate without a time column")
    scale: float = parameter(1.0, "N or m per unit of the file", "playback: factor to N or m")
    offset: float = parameter(0.0, "N or m", "playback: added after scaling")
    fade_s: float = parameter(0.2, ">= 0 s", "playback: fade in and out")
    repeat: bool = parameter(False, "-", "playback: start again at the end of the file")
    remote: RemoteHandParams = group(RemoteHandParams)

    is_hand = has("kind", "hand")  # simulated, does the session's task
    is_remote = has("kind", "remote")  # simulated; live its targets come from outside
    is_sinusoid = has("kind", "sinusoid")  # a force of one frequency
    is_chirp = has("kind", "chirp")  # a force of sweeping frequency
    has_arm = has("kind", "hand", "remote")  # on the device, follows a target
    answers = has("kind", "hand", "remote", "playback_motion")  # with a force, to the motion
    is_free = lacks("kind", "none", "hand")  # moves as it likes
    is_recorded = has("kind", "playback_force", "playback_motion")


@dataclass(frozen=True)
class TaskParams(Validated):
    """The common task of the hands; the target the server shows (App. B Fig. 6)."""

    kind: str = parameter(
        "hold",
        ("free", "hold", "carry"),
        "hold: grip and hold; carry: grip and follow the target",
    )
    grip_s: float = parameter(1.0, ">= 0 s", "time at which the hands close")
    grip_rise_s: float = parameter(1.0, "> 0 s", "duration of the closing")
    move_s: float = parameter(4.0, ">= 0 s", "time at which the target starts to move")
    distance_m: float = parameter(0.05, "m", "how far the target moves along +x")
    sideways_m: float = parameter(0.0, "m", "likewise along the second axis (dof > 1)")
    upwards_m: float = parameter(0.0, "m", "likewise along the third axis (dof > 2)")
    move_rise_s: float = parameter(3.0, "> 0 s", "duration of one minimum-jerk move")
    rest_s: float = parameter(1.0, ">= 0 s", "pause between moves")

    closes = lacks("kind", "free")  # whether the hands close
    moves = has("kind", "carry")  # whether the target moves
