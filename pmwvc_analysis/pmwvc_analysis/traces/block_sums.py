# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energies of a user at the ends of its blocks [J], and which of them count at an instant.

A master publishes its running sums once per block of M ticks, so blocks are the grain of every
energy balance. At an instant a user's energies are those of the blocks that had ended by then. A
packet leaves the master as a block begins: its energy counts from there on. A live master adds it
to the sums of the block before, a simulated one to those of the block that begins.

F_k is held while the device goes from x_k to x_{k+1}, so the hand gives the sum of
F_k . (x_{k+1} - x_k). A simulated device's is that of its true motion; a real one's, with the step
q of its encoder, may be off by up to q/2 [|F_n| + sum |F_k - F_{k-1}|] (theory.md 13.7).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import DeviceParams
from pmwvc_core.traces import UserTraces


@dataclass(frozen=True)
class BlockSums:
    """The energies of one user's blocks, ``(block,)``."""

    user: UserTraces
    live: bool = False

    @cached_property
    def ended_s(self) -> Array:
        """When each block had ended [s]: the loop ran the tick behind it."""
        user, ran_s = self.user, ticks_ran_s(self.user)
        last = user.block_ends >= len(ran_s)
        late_s = max(float(user.lateness_s[-1]), 0.0)
        ended_s = np.where(last, user.block_time_s + late_s, ran_s[self.following])
        return np.maximum.accumulate(ended_s)

    @cached_property
    def following(self) -> NDArray[np.intp]:
        """The row of the tick behind each block; behind the last one its own last tick."""
        return np.minimum(self.user.block_ends, len(self.user.time_s) - 1)

    def ended(self, times_s: Array) -> NDArray[np.intp]:
        """Return how many blocks had ended at some instants [s]."""
        return np.searchsorted(self.ended_s, times_s + 0.001 * self.user.tick_s, side="right")

    def sent(self, times_s: Array) -> NDArray[np.intp]:
        """Return of how many blocks the sums hold the packets that were sent by then [s]."""
        ended = self.ended(times_s)
        if self.live:
            return ended
        begun_s = ticks_ran_s(self.user)[np.minimum(self.user.block_rows, self.following)]
        begun = np.searchsorted(begun_s, times_s + 0.001 * self.user.tick_s, side="right")
        return np.maximum(begun, ended)

    def of_ticks(self, per_tick: Value) -> Array:
        """Return the sum of an energy per tick, ``(tick,)`` or ``(tick, 1)``."""
        return up_to(np.cumsum(per_tick), self.user.block_ends)


def ticks_ran_s(user: UserTraces) -> Array:
    """Return when each tick ran [s]."""
    return np.maximum.accumulate(user.time_s + user.lateness_s)


def up_to(sums: Array, count: NDArray[np.intp]) -> Array:
    """Return a running sum after so many rows; zero before the first."""
    return np.concatenate([[0.0], sums])[count]


def hand_work(user: UserTraces, device: DeviceParams | None) -> tuple[Array, Array]:
    """Return the work of one user's hand [J] at the ends of blocks, and how far it may be off: the
    encoder of a real one leaves it open. Without a ``device`` positions are exact.
    """
    sums, force = user.energy["device"], user.f_applied
    if device is None or device.is_simulated or device.encoder_step_m <= 0.0:
        return sums, np.zeros(len(sums))
    change = np.cumsum(np.sum(np.abs(np.diff(force, axis=0, prepend=0.0)), axis=-1))
    open_n = np.sum(np.abs(force), axis=-1) + change
    return sums, 0.5 * float(device.encoder_step_m) * open_n[user.block_ends - 1]


def measured(params: DeviceParams) -> bool:
    """Tell whether the sensors show something else than the device does."""
    return bool(params.encoder_step_m > 0.0) or params.velocity != "exact"


def complete(user: UserTraces) -> bool:
    """Tell whether the record holds every tick of the master from its first on."""
    return bool(user.tick[0] == 0 and (np.diff(user.tick) == 1).all())
