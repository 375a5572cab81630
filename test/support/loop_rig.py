# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A master's force loop between fakes, and a clock that shows what the test says."""

from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import LIVE
from pmwvc_core.params import MasterParams, ServerParams
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.scenario.scenario import User
from pmwvc_master.devices import DeviceInfo, DeviceSample
from pmwvc_master.loop import MasterLoop
from support.packer import Packer
from support.session_given import session_given

TICK_NS = 1_000_000
TICKS = 8
FRAME_S = 0.008


class Device:
    """A device that stands still and remembers what it was told."""

    def __init__(self):
        self.info = DeviceInfo(model="test", dof=1, hand_force_known=True)
        self.sample = DeviceSample(x=0.1, xd=0.02, f_h=0.5)
        self.forces = []
        self.couplings = 0
        self.stops = 0
        self.error = None

    def read(self, due_ns):
        if self.error:
            raise self.error
        return self.sample

    def write(self, f_m):
        self.forces.append(f_m)

    def couple(self):
        self.couplings += 1

    def stop(self):
        self.stops += 1


class Wires:
    """Wires that end in lists, and the link among them."""

    def __init__(self):
        self.arrived = []
        self.sent = []
        self.blocks = []
        self.energies = []
        self.missed = []

    def take(self):
        arrived, self.arrived = self.arrived, []
        return arrived

    def send(self, packet):
        self.sent.append(packet)

    def publish_trace(self, loop, block):
        series = {name: list(values) for name, values in block.series().items()}
        self.blocks.append((block.first_tick, block.start_ns, series))
        self.energies.append(block.energy)
        self.missed.append(block.missed)


class Rig:
    """A loop between fakes, and a clock that shows what the test says."""

    def __init__(self, *, rate_drop=TICKS, channel="plain"):
        self.device, self.wires, self.now_ns = Device(), Wires(), 0
        self.server = Packer(99, period=FRAME_S)
        protocol = UserEnd(
            User("user1", master=MasterParams(rate_drop=rate_drop)),
            session_given(channel=channel, server=ServerParams(period_s=FRAME_S)),
            epoch=7,
            schedule=LIVE,
        )
        self.loop = MasterLoop(
            protocol,
            self.device,
            link=self.wires,
            publish_trace=lambda *of: self.wires.publish_trace(*of),
            tick_s=0.001,
            dof=1,
            clock=lambda: self.now_ns,
        )

    def tick(self, grid, *, skipped=0):
        self.now_ns = grid * TICK_NS
        self.loop.tick(Tick(grid, self.now_ns, self.now_ns, 0, skipped))

    def ticks(self, *grids):
        for grid in grids:
            self.tick(grid)

    def answer(self, wave=0.0):
        echo = (1, self.wires.sent[-1].sent_ns, 0) if self.wires.sent else (0, 0, 0)
        self.wires.arrived.append(self.server.pack(wave, 0.0, self.now_ns, echo=echo))
