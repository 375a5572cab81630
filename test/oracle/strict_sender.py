# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A sender of the strict channel that sends any waves, over a network that does its worst."""

import numpy as np
from hypothesis import strategies as st

from pmwvc_core.transport.packet import (
    FLAG_ANEW,
    FLAG_SHORT,
    FLAG_WAITING,
    LEVEL_BITS,
    WavePacket,
)

NETWORKS = {
    "wave": st.sampled_from((0.02, 0.3, 2.0)),  # [sqrt(W)]
    "paid": st.sampled_from((0.0, 0.7, 1.0, 1.4, 3.0)),  # of what the waves carry
    "loss": st.sampled_from((0.0, 0.1, 0.4)),
    "late": st.sampled_from((0.0, 0.2, 0.6)),
    "outages_s": st.lists(st.sampled_from((0.03, 0.08, 0.2, 0.5)), max_size=3),
    "asks": st.booleans(),  # for energy
    "hostile": st.booleans(),
}
FALSE = (("energy", -0.05), ("energy", 1e3), ("energy", np.nan), ("integral", 1.0))
FALSE += (("integral", np.inf), ("wave", 1e3), ("wave", np.nan), ("period", -1.0))


class Sender:
    """Packets every ``every`` ticks of ``tick_ns``; ``now`` and all arguments are in ticks."""

    def __init__(self, network, rng, *, dof, every, tick_ns, ends):
        self.network, self.rng, self.dof, self.every = network, rng, dof, every
        self.tick_ns = tick_ns
        self.epoch = 11
        self.under_way = []
        self.mean = np.zeros(dof)
        begun = np.sort(rng.uniform(0.2 * ends, ends, len(network["outages_s"])))
        lasts = [s / (tick_ns * 1e-9) for s in network["outages_s"]]
        self.outages = [(a, a + b) for a, b in zip(begun, lasts, strict=True)]
        self.begin()

    def begin(self):
        self.seq = self.flags = self.level = 0
        self.integral, self.energy = np.zeros(self.dof), 0.0

    def restart(self, now, gone):
        """Begin a new life, and send nothing for a while."""
        self.epoch += 1
        self.begin()
        self.outages.append((now, now + gone))

    def send(self, now, echo_ns, position):
        network, rng = self.network, self.rng
        period = self.every * self.tick_ns * 1e-9
        if now % (40 * self.every) == 0:
            self.mean = network["wave"] * rng.normal(size=self.dof)
            self.share = rng.uniform(0.5, 1.5) * network["paid"]
        if rng.random() < 0.02:
            self.flags ^= FLAG_ANEW if rng.random() < 0.5 else FLAG_WAITING
        if rng.random() < 0.02:
            self.level = int(rng.integers(256))
        wave = self.mean + 0.1 * network["wave"] * rng.normal(size=self.dof)
        self.integral = self.integral + wave * period
        self.energy += 0.5 * period * self.share * float(wave @ wave)
        self.seq += 1
        asks = network["asks"] and now // 200 % 2
        form = (lambda a: float(a[0])) if self.dof == 1 else np.copy
        packet = WavePacket(
            self.epoch,
            self.seq,
            now * self.tick_ns,
            period,
            form(wave),
            form(self.integral),
            self.energy,
            form(position),
            *(1, echo_ns, 0),
            flags=self.flags | (FLAG_SHORT if asks else 0) | self.level << LEVEL_BITS,
        )
        if network["hostile"] and rng.random() < 0.05:
            name, value = FALSE[rng.integers(len(FALSE))]
            setattr(packet, name, getattr(packet, name) + value)
            if rng.random() < 0.3 and np.isfinite(value):  # and its sums go on from there
                self.energy += value * (name == "energy")
                self.integral = self.integral + value * (name == "integral")
        out = any(begin <= now < end for begin, end in self.outages)
        if out or rng.random() < network["loss"]:
            return
        ticks = int(rng.integers(1, 60)) if rng.random() < network["late"] else 0
        self.under_way.append((now + ticks, packet))
        if rng.random() < 0.05:
            self.under_way.append((now + ticks + 3, packet))

    def arrived(self, now):
        """Return what has arrived, twice: a receiver may write into its packets."""
        here = [packet for due, packet in self.under_way if due <= now]
        self.under_way = [each for each in self.under_way if each[0] > now]
        names = WavePacket.__dataclass_fields__
        return here, [WavePacket(*(getattr(each, name) for name in names)) for each in here]
