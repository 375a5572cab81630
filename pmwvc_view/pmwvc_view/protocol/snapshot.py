# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The layout of a snapshot: the newest values of a session as one row of numbers, and the packets
whose fate became known.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.numeric import Array


class Column(NamedTuple):
    """Consecutive numbers of a snapshot under one name."""

    name: str
    values: int
    unit: str


_SESSION = (("seq", "-"), ("time_s", "s"))
_VECTORS = (
    ("x_m", "m"), ("xd_m", "m/s"), ("f_h", "N"), ("f_applied", "N"), ("u_m", "sqrt(W)"),
    ("v_m", "sqrt(W)"), ("f_min", "N"), ("f_max", "N"), ("x_s", "m"), ("xd_s", "m/s"),
    ("f_s", "N"), ("target", "m"),
)  # fmt: skip
ENERGIES = tuple(
    f"energy_{way}_{amount}" for way in ("up", "down", "hand") for amount in ("in", "out", "min")
)
_NUMBERS = (
    ("presence", "-"), ("contact", "-"), ("state", "-"), ("delay_up", "s"), ("delay_down", "s"),
    *((name, "J") for name in ENERGIES),
    ("lag", "s"), ("impedance", "N s/m"), ("round_trip", "s"), ("lateness", "s"), ("held", "-"),
)  # fmt: skip
_OBJECT = (("x_o", "m"), ("xd_o", "m/s"), ("target", "m"))
POSE = 7  # values: x y z [m], quaternion w x y z
CONTACTS = 8  # of a scene, the strongest: point [m], force [N] on the first of both in poses
PACKET = [
    Column(name, 1, unit)
    for name, unit in zip(("link", "number", "sent", "arrived", "fate"), "--ss-", strict=True)
]
NO_PACKETS = np.empty((0, len(PACKET)))


class Layout:
    """The layout of a snapshot: fixed columns, then rows of packets. ``columns`` and ``slices``:
    what is in a row, and where; ``size``: its length.
    """

    def __init__(self, users: Sequence[str], dof: int, bodies: Sequence[str] = ()) -> None:
        self.users, self.dof = list(users), dof
        columns = [Column(name, 1, unit) for name, unit in _SESSION]
        for user in users:
            columns += [Column(f"{user}.{name}", dof, unit) for name, unit in _VECTORS]
            columns += [Column(f"{user}.{name}", 1, unit) for name, unit in _NUMBERS]
        columns += [Column(f"object.{name}", dof, unit) for name, unit in _OBJECT]
        columns += [Column(f"{body}.pose", POSE, "m, -") for body in bodies]
        columns += [Column("contacts", 6 * CONTACTS, "m, N")] if bodies else []
        self.columns = columns
        ends = np.cumsum([0, *(column.values for column in columns)]).tolist()
        places = map(slice, ends, ends[1:])
        self.slices = dict(zip([each.name for each in columns], places, strict=True))
        self.size = ends[-1]

    def set(self, row: Array, values: Mapping[str, Any]) -> None:
        """Write values into a row by column name; None is not known."""
        for name, value in values.items():
            row[self.slices[name]] = math.nan if value is None else value

    def positions(self, *names: str) -> list[int]:
        """Return the positions in a row of every column with one of these names, of any user."""
        return [
            at
            for name, where in self.slices.items()
            if name.rpartition(".")[2] in names
            for at in range(where.start, where.stop)
        ]

    def to_page(self) -> dict[str, object]:
        """Return the layout as the session message declares it."""
        return {
            "columns": [list(column) for column in self.columns],
            "packet": [list(column) for column in PACKET],
        }


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The session at one time: a row, and packets."""

    row: Array
    packets: Array  # (n, 5)

    @cached_property
    def message(self) -> bytes:
        """The snapshot as pages get it: the row, then the packets, little-endian."""
        every = np.concatenate([self.row, self.packets.ravel()])
        return every.astype("<f8", copy=False).tobytes()
