# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end of the channel in one object: receiver, controller, safety limits and sender.

The 1 kHz loop and the simulator call the same four methods in the order of a frame:
``send`` at the frame start, ``receive`` once a frame, ``step`` every tick, ``deliver`` whenever a
packet comes in. Time is an argument (integer nanoseconds of any monotonic clock).
"""

from pmwvc_core.master.controller import MasterController
from pmwvc_core.master.safety import SafetyLimiter
from pmwvc_core.numeric import Flag, Value, truth
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_LEAVING, FLAG_LIMITED, Packer, WavePacket
from pmwvc_core.transport.receiver import Receiver


class Client(Stateful):
    """The master's side of one user, free of ROS and clocks.

    Parameters
    ----------
    controller
        What turns motion into force and waves.
    safety
        The limits between controller and device.
    inbox
        The receiver of the returning packets.
    packer
        Numbers the outgoing packets and keeps their running sums.
    """

    BLOCKS = "controller safety inbox packer"
    MEMORY = "f_asked _events_sent _epoch"

    def __init__(
        self,
        controller: MasterController,
        safety: SafetyLimiter,
        *,
        inbox: Receiver,
        packer: Packer,
    ) -> None:
        self.controller = controller
        self.safety = safety
        self.inbox = inbox
        self.packer = packer
        self.f_asked: Value = 0.0
        self._events_sent = 0
        self._epoch = 0  # of the server whose answers are used

    def ready(self) -> bool:
        """Tell whether the server has answered and the soft start is over.

        From then on a simulated hand may act: it meets what the controller renders. Before, it
        would push the device away from its avatar against a force that is still held back.
        """
        return truth(self.safety.ready)

    def send(self, now_ns: int, *, leaving: bool = False) -> WavePacket:
        """Return the packet of this frame start: the filter's output after the last tick."""
        flags = self.controller.flags | (FLAG_LEAVING if leaving else 0)
        events = self.safety.events
        if isinstance(events, int) and events != self._events_sent:
            self._events_sent = events
            flags |= FLAG_LIMITED
        return self.packer.pack(
            self.controller.send(),
            self.controller.position(),
            now_ns,
            flags,
            self.inbox.echo(now_ns),
            self.controller.account(),
        )

    def receive(self, now_ns: int) -> None:
        """Hand the newest wave to the controller; a silent server becomes a matched damper.

        Behind another server than before, the force starts from zero.
        """
        wave = self.inbox.take(now_ns)
        if self.inbox.epoch != self._epoch:
            if self._epoch:
                self.safety.restart()
            self._epoch = self.inbox.epoch
        if self.inbox.newest is not None:
            self.controller.on_packet(self.inbox.newest)
        if self.inbox.silent(now_ns):
            self.controller.silence()
        else:
            self.controller.receive(wave)

    def step(self, x: Value, xd: Value, now_ns: int, *, sensed: Flag = True) -> Value:
        """Advance one tick and return the force the device may render [N].

        Parameters
        ----------
        x, xd
            Measured position [m] and velocity [m/s] at the start of the tick.
        now_ns
            Time of the tick.
        sensed
            Whether position and velocity can be trusted; where not, no force is rendered, and
            after it the force rises from zero. They have to be finite all the same.
        """
        controller, inbox = self.controller, self.inbox
        self.f_asked = f_asked = controller.step(x, xd)
        f_applied = self.safety.step(
            f_asked,
            x,
            xd,
            inbox.silence_s(now_ns),
            inbox.connected(),
            sensed,
        )
        controller.applied(f_applied)
        return f_applied
