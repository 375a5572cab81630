# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The judgement of a packet by itself: types, finite values, number of axes, period, size."""

import sys
from collections.abc import Callable

import numpy as np

from pmwvc_core.numeric import Value, squared
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.verdict import Verdict

LARGEST = sys.float_info.max


def unfit(
    packet: object, dof: int, max_wave: Value, *, lasts: Callable[[float], bool]
) -> Verdict | None:
    """Return the verdict on a packet that is none, or not of so many axes, or whose wave is longer
    than ``max_wave`` [sqrt(W)], or that may not stand for so long; None where it is fit.
    """
    if not isinstance(packet, WavePacket) or not _well_typed(packet):
        return Verdict.MALFORMED
    if packet.refusal is not None:
        return packet.refusal
    signals = (packet.wave, packet.integral, packet.position)
    if not all(map(_finite, (*signals, packet.energy, packet.period))):
        return Verdict.NOT_FINITE
    if not all(_fits(value, dof) for value in signals):
        return Verdict.WRONG_LENGTH
    if not lasts(packet.period):
        return Verdict.WRONG_PERIOD
    if np.any(squared(packet.wave) > max_wave**2):
        return Verdict.TOO_LARGE
    return None


def _fits(value: Value, dof: int) -> bool:
    """Tell whether a value has so many axes; the zero of a start has any number."""
    if isinstance(value, np.ndarray):
        return value.ndim > 0 and value.shape[-1] == dof
    return dof == 1 or value == 0.0


def _well_typed(packet: WavePacket) -> bool:
    numbers = (packet.epoch, packet.seq, packet.sent_ns, packet.flags, packet.came_ns)
    echo = (packet.echo_seq, packet.echo_sent_ns, packet.echo_hold_ns)
    values = (packet.wave, packet.integral, packet.energy, packet.position)
    return (
        all(isinstance(number, int) for number in numbers + echo)
        and 1 <= packet.seq < 1 << 32  # uint32 in the message
        and isinstance(packet.period, (float, int))
        and all(_is_value(value) for value in values)
        and (packet.refusal is None or isinstance(packet.refusal, Verdict))
    )


def _is_value(value: object) -> bool:
    if isinstance(value, np.ndarray):
        return bool(value.dtype == np.float64)
    return isinstance(value, (float, int))


def _finite(value: Value) -> bool:
    """As :func:`pmwvc_core.numeric.finite`, also for whole numbers beyond any float."""
    if isinstance(value, np.ndarray):
        return bool(np.isfinite(value).all())
    return -LARGEST <= value <= LARGEST
