# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session as the feed of a page takes them: blocks of a master, steps of a server.

Vectors stand in one array in the order of a row's columns, so that a row takes them at once.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_view.feed.accounts import MasterSums, ServerSums

NS = 1_000_000_000
GONE_S = 0.5  # without a trace of a node: nothing is known of it as of now
SIGNALS = ("x_m", "xd_m", "f_h", "f_applied", "u_m", "v_m")
XD_M, F_H, F_APPLIED = (SIGNALS.index(name) for name in ("xd_m", "f_h", "f_applied"))
AVATAR = ("x_s", "xd_s", "f_s")
X_M, X_S = SIGNALS.index("x_m"), AVATAR.index("x_s")
OBJECT = ("x_o", "xd_o", "target")


class TraceBlock(NamedTuple):
    """Consecutive ticks of a master; ``signals (6, ticks, dof)`` as in ``SIGNALS``, SI units."""

    start_ns: int
    period_ns: int
    signals: Array
    lateness_s: Sequence[float]  # per tick
    state: int
    reason: str
    missed: int
    sums: MasterSums | None  # None: not comparable with the server's

    @property
    def ticks(self) -> int:
        """Number of ticks."""
        return int(self.signals.shape[1])

    @property
    def f_applied(self) -> Array:
        """Force applied ``(ticks, dof)`` [N]."""
        return np.asarray(self.signals[F_APPLIED])

    @property
    def end_ns(self) -> int:
        """Time of the last tick."""
        return self.start_ns + (self.ticks - 1) * self.period_ns


class TraceStep(NamedTuple):
    """A step of the server; ``object (3, dof)`` as in ``OBJECT``, ``avatars (3, users, dof)`` as
    in ``AVATAR``; the others per user.
    """

    start_ns: int
    object: Array
    avatars: Array
    state: Sequence[int]
    contact: Sequence[bool]
    lateness_s: float
    sums: Mapping[str, ServerSums]  # by user
