# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's port at the server: wave impedance, contact, brake, and the signals of the last step.

Common to every controller. Positions of avatar and device share one frame up to ``offset``: zero
for a two-sided contact; for a grip, at joining, what it takes to start at the gap before the face.
It is constant from then on, but behind waves, where an avatar that touches nothing slides to its
device (``port``).

Not here: joining and leaving (``controller``); what is done with the signals of a step (``port``,
``baselines.direct``).
"""

from typing import Any, NamedTuple

from pmwvc_core.numeric import Value, root, squared
from pmwvc_core.params import BaselineParams
from pmwvc_core.server.avatar_brake import AvatarBrake
from pmwvc_core.server.contacts import Contact
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.transform import WavePort

DEFAULT_BASELINE = BaselineParams()
LEAST_M = 1e-3  # avatars less far from their device are not reported


class Front(NamedTuple):
    """A port in front of its brake, during a step."""

    b: Any
    wave: WavePort
    u_s: Value
    ratio: Value


class UserPort(Stateful):
    """One user's end: wave impedance ``b`` [N s/m], contact, and the signals of the last step.

    ``account`` is the running sum that goes into the user's packets [J]; None: that of the waves.
    ``kept`` is what a coupling keeps for its next step, by name; zero when the user joins.
    """

    BLOCKS = "contact brake"
    SIGNALS = "xd_s f_s kept"
    MEMORY = "offset x_s u_s v_s account packet present energy_u_s energy_v_s"
    __slots__ = (
        "account",
        "b",
        "baseline",
        "brake",
        "contact",
        "energy_u_s",
        "energy_v_s",
        "f_s",
        "front",
        "kept",
        "offset",
        "packet",
        "present",
        "u_s",
        "v_s",
        "wave",
        "x_s",
        "xd_s",
    )

    def __init__(
        self, impedance: Impedance, contact: Contact, baseline: BaselineParams = DEFAULT_BASELINE
    ) -> None:
        self.baseline = baseline
        self.account: Value | None = None
        self.packet: WavePacket | None = None
        self.brake: AvatarBrake | None = None
        self.front: Front | None = None
        self.match(impedance)
        self.contact = contact
        self.present = False
        self.offset: Value = 0.0  # [m] avatar minus device
        self.x_s: Value = 0.0  # [m]
        self.xd_s: Value = 0.0  # [m/s]
        self.f_s: Value = 0.0  # [N] on the object
        self.u_s: Value = 0.0  # [sqrt(W)]
        self.v_s: Value = 0.0  # [sqrt(W)]
        self.energy_u_s: Value = 0.0  # [J] since the start
        self.energy_v_s: Value = 0.0  # [J]
        self.kept: dict[str, Value] = {}

    def match(self, impedance: Impedance) -> None:
        """Take an impedance over; waves carry the same power with any."""
        self.b: Any = impedance  # acts like a number, also where it is a matrix
        self.wave = WavePort(impedance)

    def take(self, wave: Value) -> None:
        """Take the wave of a step [sqrt(W)]; until ``give`` a braked port is the one behind the
        brake.
        """
        self.u_s = wave
        ratio = self.brake.ratio(self.wave, wave, self.f_s) if self.brake else None
        if ratio is not None:
            self.front = Front(self.b, self.wave, wave, ratio)
            self.match(ratio * self.b)
            self.u_s = wave / root(ratio)

    def give(self, wave: Value, half_s: float) -> None:
        """Give the wave that the step returned [sqrt(W)] to the user, through the brake; count
        the energies of a step of twice ``half_s`` seconds.
        """
        front = self.front
        if front is not None and self.brake is not None:
            wave = self.brake.wave(front.u_s, (self.u_s, wave), front.ratio)
            self.b, self.wave, self.u_s, self.front = front.b, front.wave, front.u_s, None
        self.v_s = wave
        self.energy_u_s = self.energy_u_s + half_s * squared(self.u_s)
        self.energy_v_s = self.energy_v_s + half_s * squared(wave)

    def silence(self, zero: Value) -> None:
        """Forget the signals of the last step; the energies stay."""
        self.xd_s = self.f_s = self.u_s = self.v_s = zero
        self.kept = dict.fromkeys(self.kept, zero)
        if self.brake:
            self.brake.reset()


def why_kept(*, waves: bool, black_box: bool) -> str:
    """Return why a distance at joining stays, for a controller and an environment."""
    if not waves:
        return "this controller keeps the distance"
    if black_box:
        return "an environment known by its forces only has no face to stop at, so it cannot slide"
    return "it joined with the device inside the object, and slides to it once there is room"


def kept_words(distance_m: float, why: str) -> str:
    """Return the distance and why it stays; nothing below ``LEAST_M``."""
    if not distance_m > LEAST_M:
        return ""
    return f"avatar {1e3 * distance_m:.1f} mm from the device since joining: {why}"
