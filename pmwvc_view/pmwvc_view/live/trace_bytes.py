# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Traces of masters from their serialized bytes (CDR, little endian): views into the bytes cost a
third of message objects, and there are 125 a second of every user.

Only ordinary traces are read here: all columns present, no accounts of a controller's own. Others
are left to the middleware. Offsets follow from the field order in ``MasterTrace.msg``.
"""

import struct
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array

ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little endian
COLUMNS = 8  # of float64 per tick and axis: x to v_m
_HEAD = struct.Struct("<4siIqQI4xQdBB2xI")
_MIDDLE = struct.Struct("<QI?3xI")
_COUNT = struct.Struct("<I")


class Stamp(NamedTuple):
    """A time of ROS."""

    sec: int
    nanosec: int


class TraceBytes:
    """The fields of a ``MasterTrace`` without accounts, under the same names."""

    account_names: tuple[str, ...] = ()
    accounts: tuple[float, ...] = ()

    def __init__(self, data: bytes) -> None:
        """Read the fields.

        Raises
        ------
        ValueError, struct.error
            If it is no ordinary trace in this encoding.
        """
        encapsulation, *head, length = _HEAD.unpack_from(data)
        sec, nanosec, self.start_ns, self.epoch, self.seq, *head = head
        self.stamp = Stamp(sec, nanosec)
        self.first_tick, self.period, self.dof, self.state = head
        begin = _HEAD.size
        reason = data[begin : begin + length]
        self.reason = reason[:-1].decode()
        at = _aligned(begin + length)
        self.missed, self.safety_events, self.hand_force_known, values = _MIDDLE.unpack_from(
            data, at
        )
        at += _MIDDLE.size + 4
        stride = 8 * (values + 1)
        end = at + COLUMNS * stride - 8
        (ticks,) = _COUNT.unpack_from(data, end)
        *counts, late, compute, u_m, u_tx, v_rx, v_m, device, hand, names, accounts = _tail(
            values, ticks
        ).unpack_from(data, at - 8)
        regular = encapsulation == ENCAPSULATION and reason[-1:] == b"\0" and values > 0
        if not regular or set(counts) != {values} or late != compute or names or accounts:
            raise ValueError("not an ordinary trace")
        numbers = np.frombuffer(data[at:end], "<f8")
        columns = [numbers[k * (values + 1) : k * (values + 1) + values] for k in range(COLUMNS)]
        self.x, self.xd, self.f_h, self.f_m, self.f_applied, self.u_m, self.u_m_lp, self.v_m = (
            columns
        )
        self.lateness = _floats(data, end + 4, ticks)
        self.compute = _floats(data, end + 8 + 4 * ticks, ticks)
        self.energy_u_m, self.energy_u_tx, self.energy_v_rx, self.energy_v_m = u_m, u_tx, v_rx, v_m
        self.energy_device, self.energy_hand = device, hand


def _aligned(at: int) -> int:
    """Return the next offset at a multiple of 8 behind the encapsulation."""
    return (at + 3) // 8 * 8 + 4


@lru_cache(maxsize=64)
def _tail(values: int, ticks: int) -> struct.Struct:
    """Return the layout from the count of x on: counts, energies, counts of accounts."""
    column = f"I{4 + 8 * values}x"
    return struct.Struct(f"<{COLUMNS * column}I{4 * ticks}xI{4 * ticks}x6dII")


def _floats(data: bytes, at: int, count: int) -> Array:
    return np.frombuffer(data, "<f4", count, at)
