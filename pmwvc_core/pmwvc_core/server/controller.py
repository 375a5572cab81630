# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The interface of every controller at the server's end, and what all have in common: the users
around one object, joining, leaving, and what traces read.

Joining stores no energy: the contact begins without force. Leaving drops what its spring holds. A
user who comes back joins anew. Not here: what is done with the signals of a step (``port``,
``baselines.direct``).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from pmwvc_core.numeric import Flag, Value
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.avatar_brake import BRAKES, AvatarBrake
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.impedance import Impedance

NO_ACCOUNTS: Mapping[str, Value] = MappingProxyType({})


class ServerController(Stateful, ABC):
    """The users around one object behind any controller; a controller adds ``step``.

    All attributes and properties give the state after the last step; lists are in the order of the
    users.
    """

    BLOCKS = "body ports faults"
    MEMORY = "dissipated"
    flags = 0  # of outgoing packets
    faults: Faults | None = None  # with an environment, or with the solution of a step

    def __init__(self, body: Body, ports: Sequence[UserPort]) -> None:
        self.body = body
        self.ports = list(ports)
        self.dissipated: Value = 0.0  # [J] heat of contacts and ground, springs let go

    @abstractmethod
    def step(self, received: Sequence[Any]) -> list[Value]:
        """Go one step of the environment on.

        Parameters
        ----------
        received : sequence
            Per user what the controller's master sent: a wave ``(..., dof)`` [sqrt(W)] or, for
            direct coupling, a pair of position [m] and velocity [m/s]. Ignored for users who are
            not present.

        Returns
        -------
        list
            Per user what goes back: a wave [sqrt(W)] or a force [N]; 0.0 for users who are not
            present.
        """

    def configure(self, params: ServerParams) -> None:
        """Take other parameters of object and coupling over; no energy comes or goes."""
        self.body.configure(params.object_mass, params.object_damping, period=params.period_s)
        for port in self.ports:
            if port.brake:
                port.brake.last(params.period_s)

    def configure_user(self, i: int, contact: ContactParams, impedance: Impedance) -> None:
        """Take other parameters of user ``i`` over; the spring stores what it stored."""
        port = self.ports[i]
        lost = port.contact.configure(contact.contact_stiffness, contact.contact_damping)
        self.dissipated = self.dissipated + lost
        port.match(impedance)

    def on_packet(self, i: int, packet: WavePacket) -> None:
        """Note the newest packet of user ``i`` before a step, for what is beside its wave."""
        self.ports[i].packet = packet

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies that only this controller keeps, by name [J]; always the same names."""
        brakes = [port.brake for port in self.ports if port.brake]
        if not brakes:
            return NO_ACCOUNTS
        heat: Value = 0.0
        for brake in brakes:
            heat = heat + brake.heat_j
        return {BRAKES: heat}

    def fit_brakes(self, period_s: float) -> None:
        """Give every avatar a brake, for waves that may fail to come (the strict channel)."""
        for port in self.ports:
            port.brake = AvatarBrake(period_s=period_s)

    def interrupt(self, i: int, interrupted: Flag) -> None:
        """Note whether no waves of user ``i`` come, before a step."""
        brake = self.ports[i].brake
        if brake:
            brake.waits = interrupted

    def join(self, i: int, position: Value) -> None:
        """Let user ``i`` join with an avatar at the device's position [m]; no force, no energy.

        A user already present leaves first.
        """
        port = self.ports[i]
        if port.present:
            self.leave(i)
        zero = 0.0 * position  # gives signals and object their shape
        port.silence(zero)
        self.body.x = self.body.x + zero
        self.body.xd = self.body.xd + zero
        port.contact.attach(position - self.body.x)
        port.x_s = self.body.x + port.contact.position
        port.offset = port.x_s - position
        port.present = True

    def leave(self, i: int) -> None:
        """Take user ``i`` out; the energy of the spring is dropped."""
        port = self.ports[i]
        if port.present:
            self.dissipated = self.dissipated + port.contact.detach()
            port.silence(0.0 * port.f_s)
            port.present = False

    def learned(self, i: int) -> Value | None:
        """Return (K T + 2B)/b of what user ``i`` touches, where its port learns it."""
        return None

    def _present_ports(self) -> list[UserPort]:
        return [port for port in self.ports if port.present]

    @property
    def present(self) -> list[bool]:
        """Flags of the users that are present."""
        return [port.present for port in self.ports]

    @property
    def contact(self) -> list[Flag]:
        """Whose avatar touches the object."""
        return [port.contact.touching if port.present else False for port in self.ports]

    @property
    def offset(self) -> list[Value]:
        """Avatar minus device where no motion is under way or missing, without force [m]."""
        return [port.offset for port in self.ports]

    @property
    def x_o(self) -> Value:
        """Position of the object [m]."""
        return self.body.x

    @property
    def xd_o(self) -> Value:
        """Velocity of the object [m/s]."""
        return self.body.xd

    @property
    def x_s(self) -> list[Value]:
        """Positions of the avatars [m]."""
        return [port.x_s for port in self.ports]

    @property
    def xd_s(self) -> list[Value]:
        """Velocities of the avatars [m/s]."""
        return [port.xd_s for port in self.ports]

    @property
    def f_s(self) -> list[Value]:
        """Contact forces on the object [N]."""
        return [port.f_s for port in self.ports]

    @property
    def u_s(self) -> list[Value]:
        """Waves used [sqrt(W)]."""
        return [port.u_s for port in self.ports]

    @property
    def v_s(self) -> list[Value]:
        """Waves returned [sqrt(W)]."""
        return [port.v_s for port in self.ports]

    @property
    def energy_u_s(self) -> list[Value]:
        """Energies received since the start [J]."""
        return [port.energy_u_s for port in self.ports]

    @property
    def energy_v_s(self) -> list[Value]:
        """Energies returned since the start [J]."""
        return [port.energy_v_s for port in self.ports]

    @property
    def kinetic(self) -> Value:
        """Kinetic energy of the object [J]."""
        return self.body.kinetic

    @property
    def potential(self) -> Value:
        """Energy of all contact springs [J]."""
        energy: Value = 0.0
        for port in self.ports:
            if port.present:
                energy = energy + port.contact.energy
        return energy
