# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The work of the hand at the port where it is: the force applied times the distance moved.

F_k is held while the device goes from x_k to x_{k+1}, so the hand gives the sum of
F_k . (x_{k+1} - x_k). The master records that sum at the end of every block: a simulated device's
is that of its true motion; a real one's, with the step q of its encoder, may be off by up to
q/2 [|F_n| + sum |F_k - F_{k-1}|] (theory.md 13.7).
"""

from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces.block_sums import BlockSums
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.traces import UserTraces


class HandWork(NamedTuple):
    """The work of the hand [J] at the ends of blocks, and how far it may be off."""

    sums: Array
    resolution: Array


def hand_work(user: UserTraces, device: DeviceParams | None) -> HandWork:
    """Return the work of one user's hand. The encoder of a real one leaves it open. Without a
    ``device`` positions are exact.
    """
    blocks, force = BlockSums(user), user.f_applied
    moved = np.diff(user.x_m, axis=0, append=user.x_m[-1:])
    counted = blocks.of_ticks(np.sum(force * moved, axis=-1))
    sums = user.energy.get("device", counted)
    true = device is None or (device.is_simulated and "device" in user.energy)
    if device is None or true or device.encoder_step_m <= 0.0:
        return HandWork(sums, np.zeros(len(sums)))
    change = np.cumsum(np.sum(np.abs(np.diff(force, axis=0, prepend=0.0)), axis=-1))
    open_n = np.sum(np.abs(force), axis=-1) + change
    return HandWork(sums, 0.5 * float(device.encoder_step_m) * open_n[user.block_ends - 1])


def measured(params: DeviceParams) -> bool:
    """Tell whether the sensors show something else than the device does."""
    return bool(params.encoder_step_m > 0.0) or params.velocity != "exact"


def complete(user: UserTraces) -> bool:
    """Tell whether the record holds every tick of the master from its first on."""
    return bool(user.tick[0] == 0 and (np.diff(user.tick) == 1).all())
