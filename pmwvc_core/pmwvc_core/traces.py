# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as arrays ``(..., tick, dof)``, the same for a live run, a simulated
run and a recording. Times are seconds since the start of the session.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array, Integers

ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")  # sums of a master
OF_AVATARS = ("x_s", "xd_s", "f_s", "u_s", "v_s")  # of each user at the server


def _unknown(kind: type = np.int64) -> Any:
    """Declare a column that a recording may not say."""
    return field(default_factory=lambda: np.zeros(0, dtype=kind))


@dataclass
class UserTraces:
    """One master: a row per executed tick, energies at the end of each block of M ticks. ``f_h``
    is NaN where it is not known; ``state``: 0 starting, 1 coupled, 2 damping, 3 fault.
    """

    name: str
    tick_s: float
    time_s: Array  # (tick,)
    tick: Integers  # (tick,) number of the tick, consecutive when nothing is missing
    x_m: Array  # (..., tick, dof) [m]
    xd_m: Array  # [m/s]
    f_h: Array  # [N] hand on device
    f_m: Array  # [N] asked for by the controller
    f_applied: Array  # [N] after the safety limits
    u_m: Array  # [sqrt(W)]
    u_m_lp: Array
    v_m: Array
    lateness_s: Array  # (tick,) wake-up behind its deadline; zero in virtual time
    compute_s: Array  # (tick,)
    block_time_s: Array  # (block,) end of each block
    state: Integers  # (..., block)
    reason: list[str]  # (block,) why the state is what it is, "" when coupled
    energy: dict[str, Array]  # ENERGIES -> (..., block) [J]
    missed: int = 0
    safety_events: Any = 0
    accounts: dict[str, Array] = field(default_factory=dict)  # (..., block) [J]
    block_number: Integers = _unknown()  # (block,) consecutive where none is missing
    epoch: NDArray[np.uint64] = _unknown(np.uint64)  # (block,) start of the master
    changes: Integers = _unknown()  # (block,) frames up to it that took changes over
    looked_ns: Integers = _unknown()  # (tick,) from the deadline until packets were taken in
    grid: int = 0  # ticks of the loop's clock before tick 0: frames begin at its multiples of M

    @property
    def block_rows(self) -> Integers:
        """The first tick of each block, as a row of the ticks."""
        return np.concatenate([[0], self.block_ends[:-1]]).astype(np.int64)

    @property
    def block_ends(self) -> Integers:
        """The row behind the last tick of each block."""
        return np.searchsorted(self.time_s, self.block_time_s - 0.5 * self.tick_s)

    def rows_at(self, times_s: Array) -> Integers:
        """Return the rows of the ticks at some times [s]; the last one for what is later."""
        rows = np.searchsorted(self.time_s, times_s - 0.5 * self.tick_s)
        return np.minimum(rows, len(self.time_s) - 1)

    @property
    def nearest_look_ns(self) -> Integers:
        """When packets were taken in, as looked_ns, or the wake-up where that is not known."""
        if len(self.looked_ns):
            return self.looked_ns
        return np.rint(np.maximum(self.lateness_s, 0.0) * 1e9).astype(np.int64)


@dataclass
class ServerTraces:
    """The server: a row per step of the environment; lists per user in the order of ``users``."""

    users: list[str]
    periods_s: Array  # (step,) [s] how long each step lasts
    time_s: Array  # (step,)
    step: Integers  # (step,)
    x_o: Array  # (..., step, dof)
    xd_o: Array
    target: Array  # (..., step, dof)
    x_s: list[Array]
    xd_s: list[Array]
    f_s: list[Array]
    u_s: list[Array]
    v_s: list[Array]
    contact: list[NDArray[np.bool_]]  # (..., step)
    state: list[Integers]  # 0 absent, 1 joining, 2 coupled, 3 damping
    energy_u_s: list[Array]  # (..., step) running sums [J]
    energy_v_s: list[Array]
    kinetic: Array  # (..., step) [J]
    potential: Array
    dissipated: Array
    accounts: dict[str, Array] = field(default_factory=dict)  # (..., step) [J]
    changes: Integers = _unknown()  # (step,) steps up to it that took changes over
    looked_ns: Integers = _unknown()  # (step,) from the deadline until packets were taken in

    @property
    def nearest_look_ns(self) -> Integers:
        """When packets were taken in, as looked_ns, or the deadline where that is not known."""
        known = len(self.looked_ns) > 0
        return self.looked_ns if known else np.zeros(len(self.time_s), dtype=np.int64)

    @property
    def period_s(self) -> float:
        """Length of the longest step [s]: of all, where it did not change."""
        return float(self.periods_s.max(initial=0.0))


@dataclass
class PacketTraces:
    """The packets seen on one topic, in the order recorded."""

    topic: str
    time_s: Array  # when recorded
    epoch: NDArray[np.uint64]
    seq: Integers
    sent_ns: Integers  # the sender's monotonic clock
    period_s: Array  # time that each stands for
    wave: Array  # (packet, dof)
    integral: Array
    energy: Array
    position: Array  # (packet, dof) [m] of the sending end; an avatar's in the frame of its device


@dataclass
class FateTraces:
    """The fates of a link's packets; times on the emulator's monotonic clock."""

    link: str
    number: Integers
    epoch: NDArray[np.uint64]
    seq: Integers
    size_bytes: Integers
    time_in_ns: Integers
    time_due_ns: Integers
    time_out_ns: Integers  # 0: never
    fate: Integers  # 0 delivered, 1 lost, 2 duplicate, 3 dropped by rate, 4 queue full, 5 invalid
    cause: Integers


@dataclass
class TakenTraces:
    """The packets that a receiver was given, in their order, without those refused."""

    row: Integers  # tick of the master, step of the server: row of its traces
    seq: Integers
    epoch: Integers  # lowest 32 bits

    def before(self, rows: int) -> "TakenTraces":
        """Return the packets taken in by the first rows of the traces."""
        kept = self.row < rows
        return TakenTraces(self.row[kept], self.seq[kept], self.epoch[kept])


@dataclass
class HandTargets:
    """The targets of a remote hand in the order of arrival; a row of NaN lets go."""

    time_s: Array  # (target,)
    position: Array  # (target, 3) [m]


@dataclass
class ReceptionTraces:
    """The packets received at the end of a link by the end of a session, over all its starts."""

    link: str
    receivers: int  # starts of the receiving node
    counts: dict[str, int]  # by the names of the Reception message
    passage: dict[str, float]  # the last that is known, by the same names; NaN: unknown


@dataclass
class SessionTraces:
    """Everything recorded of one session, ``live``, ``simulated`` or ``replayed``. ``events`` are
    findings: ``{"time_s": float | None, "what": str, "who": str}``; ``counts`` holds per topic
    ``messages``, ``missing``, and ``not_relayed`` where packets never came to the emulated link;
    ``settings`` are parameters that changed live: time [s], and values by scenario names.
    """

    source: str
    duration_s: float
    users: list[UserTraces]
    server: ServerTraces | None
    packets: dict[str, PacketTraces] = field(default_factory=dict)
    fates: dict[str, FateTraces] = field(default_factory=dict)
    receptions: dict[str, ReceptionTraces] = field(default_factory=dict)
    taken: dict[str, TakenTraces] = field(default_factory=dict)
    link_states: dict[str, dict[str, Array]] = field(default_factory=dict)
    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    events: list[dict[str, Any]] = field(default_factory=list)
    metadata: dict[str, Any] = field(default_factory=dict)
    settings: list[tuple[float, dict[str, Any]]] = field(default_factory=list)
    targets: dict[str, HandTargets] = field(default_factory=dict)  # by user

    @property
    def live(self) -> bool:
        """Whether the session ran in real time."""
        return self.source == "live"

    @property
    def simulated(self) -> bool:
        """Whether the session ran in virtual time only."""
        return self.source == "simulated"
