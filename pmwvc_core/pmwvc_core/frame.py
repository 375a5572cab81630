# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When, after the start of a frame, both ends act; samples that masters act on, and rows that both
ends report: of a tick, a frame, a step.
"""

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pmwvc_core.law.user_tick import STALE_NS as STALE_NS
from pmwvc_core.law.user_tick import next_on_grid
from pmwvc_core.numeric import Flag, Value

# Of a tick: x_m [m], xd_m [m/s], f_h, f_m, f_applied [N], u_m, u_m_lp, v_m [sqrt(W)].
Row = tuple[Value, Value, Value, Value, Value, Value, Value, Value]
SIGNALS = ("x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")


@dataclass(slots=True)
class DeviceSample:
    """Motion and forces that a device senses at one tick.

    ``valid`` is False where the motion cannot be trusted: no force then. ``fresh`` is False where
    nothing new came since the last read; ``measured_ns`` is of the monotonic clock, None: of the
    read. ``f_h`` is zero where ``hand_force_known`` is False. ``work`` [J] since the start, of the
    controller's force against the hand and of the hand's on the device, is for devices that know
    their true motion; None: the loop counts the motion measured. A device of six axes may give its
    ``orientation``, x y z w; () where that follows from the way of axes 4 to 6.
    """

    x: Value = 0.0  # [m]
    xd: Value = 0.0  # [m/s]
    f_h: Value = 0.0  # [N]
    valid: bool = True
    work: tuple[Value, Value] | None = None
    fresh: bool = True
    measured_ns: int | None = None
    outside: bool = False
    buttons: int = 0
    orientation: tuple[float, ...] = ()


class FrameReport(NamedTuple):
    """Safety state and running sums of energy at the end of a frame [J]."""

    state: int
    reason: str
    u_m: Value
    u_tx: Value
    v_rx: Value
    v_m: Value
    accounts: Mapping[str, Value]
    orientation: tuple[float, ...]  # of the device, x y z w; () below six axes


class Presence(enum.IntEnum):
    """State of a user at the server; the numbers are those of the ServerTrace message."""

    ABSENT = 0
    JOINING = 1
    COUPLED = 2
    DAMPING = 3


class ServerRow(NamedTuple):
    """The server after a step; one entry per user in every sequence."""

    x_o: Value  # [m]
    xd_o: Value  # [m/s]
    target: Value  # [m]
    kinetic: Value  # [J]
    potential: Value  # [J]
    dissipated: Value  # [J]
    x_s: Sequence[Value]  # [m]
    xd_s: Sequence[Value]  # [m/s]
    f_s: Sequence[Value]  # [N]
    u_s: Sequence[Value]  # [sqrt(W)]
    v_s: Sequence[Value]  # [sqrt(W)]
    energy_u_s: Sequence[Value]  # [J]
    energy_v_s: Sequence[Value]  # [J]
    contact: Sequence[Flag]
    state: tuple[Presence, ...]
    accounts: Mapping[str, Value]  # [J]
    poses: Mapping[str, Sequence[float]]  # of bodies [m] x y z, quaternion w x y z
    contacts: Sequence[float]  # of bodies, 8 numbers each: pmwvc_core.server.black_box.shown_by
    contained: int  # steps so far in which environment or coupling was replaced


@dataclass(frozen=True)
class FrameSchedule:
    """Phases of a frame [s]: the server steps ``server_s`` after its start, on a grid of its own
    period; a master takes the newest answer after ``answer_s``. Zero for both: one instant.
    """

    server_s: float = 0.0
    answer_s: float = 0.0

    def server_tick(self, *, tick_s: float, period_ticks: int) -> int:
        """Return the tick of its period at which the server steps."""
        return round(self.server_s / tick_s) % period_ticks

    def next_step(self, tick: int, *, tick_s: float, period_s: float) -> int:
        """Return the first tick after another one at which the server steps."""
        every = round(period_s / tick_s)
        return next_on_grid(tick, every, self.server_tick(tick_s=tick_s, period_ticks=every))

    def answer_tick(self, *, tick_s: float, rate_drop: int) -> int:
        """Return the tick of a frame that takes the answer, the last one of shorter frames."""
        return min(round(self.answer_s / tick_s), rate_drop - 1)


AT_ONCE = FrameSchedule()  # virtual time
# One machine: the server's step and two ways through the emulator fit between the phases.
LIVE = FrameSchedule(server_s=0.002, answer_s=0.004)
