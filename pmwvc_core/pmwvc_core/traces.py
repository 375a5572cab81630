# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as arrays ``(..., tick, dof)``, the same for a live run, a simulated
run and a recording. Times are seconds since the start of the session.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import AXES, Array, Integers

ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")  # sums of a master
OF_AVATARS = ("x_s", "xd_s", "f_s", "u_s", "v_s")  # of each user at the server
OF_USERS = (*OF_AVATARS, "contact", "state", "energy_u_s", "energy_v_s")  # likewise
Looks = Annotated[Integers, "ns", "look at the packets that had come, behind the deadline"]


def _unknown(kind: type = np.int64) -> Any:
    """Declare a column that a recording may not say."""
    return field(default_factory=lambda: np.zeros(0, dtype=kind))


@dataclass
class UserTraces:
    """One master: a row per executed tick, energies at the end of each block of M ticks."""

    name: str
    tick_s: float
    time_s: Annotated[Array, "s", "time since the start of the session"]  # (tick,)
    tick: Annotated[Integers, "", "number of the tick of the force loop"]
    x_m: Annotated[Array, "m", "position of the device"]  # (..., tick, dof)
    xd_m: Annotated[Array, "m/s", "velocity of the device"]
    f_h: Annotated[Array, "N", "force of the hand on the device; NaN where it is not known"]
    f_m: Annotated[Array, "N", "force asked for by the controller"]
    f_applied: Annotated[Array, "N", "force on the device, after the safety limits"]
    u_m: Annotated[Array, "sqrt(W)", "wave out of the master before its filter"]
    u_m_lp: Annotated[Array, "sqrt(W)", "wave out of the master after its filter"]
    v_m: Annotated[Array, "sqrt(W)", "wave into the master after the hold"]
    lateness_s: Annotated[Array, "s", "wake-up behind its deadline"]  # zero in virtual time
    compute_s: Annotated[Array, "s", "time the tick took"]
    block_time_s: Array  # (block,) end of each block
    state: Integers  # (..., block) 0 starting, 1 coupled, 2 damping, 3 fault
    reason: list[str]  # (block,) why the state is what it is, "" when coupled
    energy: dict[str, Array]  # ENERGIES -> (..., block) [J]
    missed: int = 0
    safety_events: Any = 0
    accounts: dict[str, Array] = field(default_factory=dict)  # (..., block) [J]
    block_number: Integers = _unknown()  # (block,) consecutive where none is missing
    epoch: NDArray[np.uint64] = _unknown(np.uint64)  # (block,) start of the master
    changes: Integers = _unknown()  # (block,) frames up to it that took changes over
    looked_ns: Looks = _unknown()  # (tick,)
    orientation: Array = _unknown()  # (block, 4) of the device, x y z w; (block, 0) below six axes
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


@dataclass
class ServerTraces:
    """The server: a row per step of the environment; lists per user in the order of ``users``."""

    users: list[str]
    time_s: Annotated[Array, "s", "time since the start of the session"]  # (step,)
    step: Annotated[Integers, "", "number of the step of the server"]
    periods_s: Annotated[Array, "s", "how long the step lasts"]
    x_o: Annotated[Array, "m", "position of the object"]  # (..., step, dof)
    xd_o: Annotated[Array, "m/s", "velocity of the object"]
    target: Annotated[Array, "m", "where the task wants the object"]
    x_s: Annotated[list[Array], "m", "position of the avatar"]
    xd_s: Annotated[list[Array], "m/s", "velocity of the avatar"]
    f_s: Annotated[list[Array], "N", "contact force on the avatar"]
    u_s: Annotated[list[Array], "sqrt(W)", "wave received by the server"]
    v_s: Annotated[list[Array], "sqrt(W)", "wave sent by the server"]
    contact: Annotated[list[NDArray[np.bool_]], "", "1 in contact with the object"]  # (..., step)
    state: Annotated[list[Integers], "", "0 absent, 1 joining, 2 coupled, 3 damping"]
    energy_u_s: Annotated[list[Array], "J", "energy of the waves received so far"]
    energy_v_s: Annotated[list[Array], "J", "energy of the waves sent so far"]
    kinetic: Annotated[Array, "J", "kinetic energy of the object"]  # (..., step)
    potential: Annotated[Array, "J", "energy stored in the springs of the contacts"]
    dissipated: Annotated[Array, "J", "heat of object and contacts so far"]
    accounts: dict[str, Array] = field(default_factory=dict)  # (..., step) [J]
    poses: dict[str, Array] = field(default_factory=dict)  # of bodies (step, 7): xyz [m], wxyz
    scene: dict[str, Any] = field(default_factory=dict)  # what an environment says of itself
    contacts: Array = field(default_factory=lambda: np.zeros((0, 9)))  # contact_rows
    contained: Integers = _unknown()  # (step,) steps up to it that were replaced
    changes: Integers = _unknown()  # (step,) steps up to it that took changes over
    looked_ns: Looks = _unknown()  # (step,)

    @property
    def replaced(self) -> tuple[float, int]:
        """From when [s] and in how many steps environment or coupling was replaced."""
        steps = int(self.contained.max(initial=0))
        return (float(self.time_s[np.argmax(self.contained > 0)]) if steps else 0.0), steps

    @property
    def period_s(self) -> float:
        """Length of the longest step [s]: of all, where it did not change."""
        return float(self.periods_s.max(initial=0.0))


def contact_rows(steps: Sequence[Sequence[float]]) -> Array:
    """Return contacts ``(contact, 9)``: row of the step, two bodies of ``poses`` by index (-1: a
    fixed one), x y z [m], force on the second [N].
    """
    rows = np.repeat(np.arange(len(steps)), [len(step) // 8 for step in steps])
    values: Array = np.concatenate([np.zeros(0), *steps]).reshape(-1, 8)
    return np.column_stack([rows, values])


@dataclass
class PacketTraces:
    """The packets seen on one topic, in the order recorded."""

    topic: str
    time_s: Annotated[Array, "s", "when the packet was recorded"]
    epoch: Annotated[NDArray[np.uint64], "", "which start of the sender sent it"]
    seq: Annotated[Integers, "", "number of the packet"]
    sent_ns: Annotated[Integers, "ns", "time of sending on the sender's monotonic clock"]
    period_s: Array  # time that each stands for
    wave: Annotated[Array, "sqrt(W)", "the wave in the packet"]  # (packet, dof)
    integral: Annotated[Array, "sqrt(W) s", "running integral of the wave"]
    energy: Annotated[Array, "J", "energy sent so far"]
    position: Annotated[Array, "m", "sending end; an avatar's in the frame of its device"]
    orientation: Annotated[Array, "", "sending end, unit quaternion x y z w; none below six axes"]


@dataclass
class FateTraces:
    """The fates of a link's packets; times on the emulator's monotonic clock."""

    link: str
    number: Annotated[Integers, "", "number of the packet on the link"]
    epoch: Annotated[NDArray[np.uint64], "", "which start of the sender sent it"]
    seq: Annotated[Integers, "", "number given by the sender"]
    size_bytes: Annotated[Integers, "bytes", "size of the packet"]
    time_in_ns: Annotated[Integers, "ns", "when it came in, on the emulator's monotonic clock"]
    time_due_ns: Annotated[Integers, "ns", "when it was due to go out"]
    time_out_ns: Annotated[Integers, "ns", "when it went out; 0: never"]
    fate: Annotated[Integers, "", "0 delivered, 1 lost, 2 copy, 3 rate limit, 4 queue, 5 invalid"]
    cause: Annotated[Integers, "", "what decided the fate: CAUSE_* of PacketFate.msg, 0 none"]


@dataclass
class TakenTraces:
    """The packets that a receiver was given, in their order, without those refused."""

    row: Integers  # tick of the master, step of the server: row of its traces
    seq: Integers
    epoch: Integers  # lowest 32 bits


@dataclass
class HandTargets:
    """The targets of a remote hand in the order of arrival; a row of NaN lets go."""

    time_s: Array  # (target,)
    position: Array  # (target, 3) [m]
    turn: Array = field(default_factory=lambda: np.zeros(3))  # (target, 3) sums of turns [rad]

    def ways(self, scenario: Any) -> Array:
        """Return the targets along the axes of a scenario [m], of the last three at the lever."""
        turns = np.broadcast_to(scenario.server.lever_m * self.turn, self.position.shape)
        return np.hstack([self.position, turns])[:, : scenario.dof]


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
    ``messages`` and ``missing``; ``settings`` are parameters that changed live: time [s], and
    values by scenario names.
    """

    source: str
    duration_s: float
    users: list[UserTraces]
    server: ServerTraces | None
    packets: dict[str, PacketTraces] = field(default_factory=dict)
    fates: dict[str, FateTraces] = field(default_factory=dict)
    receptions: dict[str, ReceptionTraces] = field(default_factory=dict)
    taken: dict[str, TakenTraces] = field(default_factory=dict)
    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    events: list[dict[str, Any]] = field(default_factory=list)
    metadata: dict[str, Any] = field(default_factory=dict)
    settings: list[tuple[float, dict[str, Any]]] = field(default_factory=list)
    targets: dict[str, HandTargets] = field(default_factory=dict)  # by user

    @property
    def live(self) -> bool:
        """Whether the session ran in real time."""
        return self.source == "live"


def load_of(axis: int, scenario: Any) -> tuple[str, str, float]:
    """Return name, unit and factor of what is recorded along an axis; a torque is at the lever."""
    torque = scenario is not None and axis > 2
    return ("torque", "N m", scenario.server.lever_m) if torque else ("force", "N", 1.0)


def loads(f: Array, scenario: Any) -> list[tuple[str, str, Array]]:
    """Return name, unit and part of forces ``(..., dof)``."""
    if scenario is None or f.shape[-1] != AXES:
        return [("force", "N", f)]
    name, unit, lever_m = load_of(3, scenario)
    return [("force", "N", f[..., :3]), (name, unit, lever_m * f[..., 3:])]
