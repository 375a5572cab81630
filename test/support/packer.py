# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A sender of packets without a law behind it."""

import numpy as np

from pmwvc_core.numeric import AXES, Value, squared
from pmwvc_core.quaternions import IDENTITY
from pmwvc_core.transport.packet import LAST_NUMBER, WavePacket


class Packer:
    """Number the packets of one life of a sender and keep their running sums. Its ``epoch`` is
    different from all others; a sample stands for ``period`` [s], which may change between two.
    """

    def __init__(self, epoch: int, *, period: float) -> None:
        self.epoch = epoch
        self.period = period
        self.seq = 0
        self.integral: Value = 0.0
        self.energy: Value = 0.0

    def pack(
        self, wave: Value, position: Value, now_ns: int, flags: int = 0,
        echo: tuple[int, int, int] = (0, 0, 0), energy: Value | None = None,
    ) -> WavePacket:  # fmt: skip
        """Return the next packet of a wave [sqrt(W)] and the position of this end [m], each a
        float or ``(dof,)``. ``flags`` is the bitwise or of ``FLAG_*``, ``echo`` the answer of
        :meth:`Receiver.echo` for the peer; ``energy`` [J] is a running sum that a controller keeps
        itself, by default that of the waves sent.
        """
        self.seq = self.seq % LAST_NUMBER + 1
        self.integral = self.integral + wave * self.period
        self.energy = self.energy + squared(wave) * (0.5 * self.period)
        kept = self.energy if energy is None else energy
        sums = (wave, self.integral, kept, position)
        turned = IDENTITY if np.size(wave) == AXES else ()
        about = {"flags": flags, "orientation": turned}
        return WavePacket(self.epoch, self.seq, now_ns, self.period, *sums, *echo, **about)
