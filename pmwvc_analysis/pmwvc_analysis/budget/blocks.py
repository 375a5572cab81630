# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The accounts of a user's blocks [J], at the ends of the blocks of its record.

======================  ==========================================================================
device                  ``plant.device.device_account``
safety                  F xd dt less (|u_m|^2 - |v_m|^2) dt/2, in ticks that were limited
filter, rate drop,      differences of the energies of u_m, u_m after the filter, u_tx, u_s and of
links, hold             v_s, v_rx, v_m: the passages of ``controllers.accounts``
port filters, position  what velocity filter, bank and position feedback account for themselves
======================  ==========================================================================

Equations: docs/theory.md 13.5.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget.parts import accounted
from pmwvc_analysis.budget.result import Sums
from pmwvc_analysis.traces.block_sums import BlockSums, complete, measured, up_to
from pmwvc_analysis.traces.sums import sum_of
from pmwvc_core.account import Account, Passage, wave_energy
from pmwvc_core.controllers.accounts import FILTER, HOLD, RATE_DROP, RELEASED, passages
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.law.wave.wave import wave_force, wave_u
from pmwvc_core.made.waves import through
from pmwvc_core.numeric import Array, dot, squared
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import device_account
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import LINK, LINK_DOWN, LINK_UP

SAME_N, SAME_ROOT_W = 1e-9, 1e-9  # forces and waves closer than this are the same


def device(blocks: BlockSums, params: DeviceParams) -> tuple[Account, set[str]]:
    """Return the account of a device, and which of its parts are remainders.

    A hand whose force was not measured is taken to have given what the device shows, and any hand
    the energy with which the record begins. Where a sensor measures the motion, the damping is
    what the others leave over.
    """
    user = blocks.user
    by_hand = bool(np.isfinite(user.f_h).all())
    kinetic = 0.5 * params.mass * np.sum(user.xd_m**2, axis=-1)
    brought_j = kinetic[0] if user.tick[0] == 0 else 0.0  # else the hand's own sums have it
    if measured(params):
        rendered, stored = user.energy["device"], kinetic[blocks.following]
        hand = brought_j + user.energy["hand"] if by_hand else rendered + stored
        seen = Account(hand, rendered, stored)
        return seen._replace(dissipated=seen.residual), {"device_damping"} if by_hand else {"hand"}
    following = np.minimum(np.arange(1, len(user.time_s) + 1), len(user.time_s) - 1)
    after = user.x_m[following], user.xd_m[following]
    forces = user.f_h if by_hand else None, user.f_applied
    each = device_account(params, user.tick_s, (user.x_m, user.xd_m), after, *forces)
    own = {} if complete(user) else user.energy  # by the ticks where all are on record
    given, taken = own.get("device", blocks.of_ticks(each.given)), blocks.of_ticks(each.taken)
    stored, heat = kinetic[0] + blocks.of_ticks(each.stored), blocks.of_ticks(each.dissipated)
    hand = brought_j + own.get("hand", taken) if by_hand else given + stored + heat
    return Account(hand, given, stored, heat), set() if by_hand else {"hand"}


class OfUser(NamedTuple):
    """The energies of one user at the instants: of the hand, of the parts, and unexplained."""

    hand: Array
    parts: Sums
    residual: Array
    remainders: frozenset[str]  # those of the parts


def of_user(at: "At", known: User, scenario: Scenario) -> OfUser:
    """Return the accounts of one user. Around ticks that were skipped both ends are known, and the
    rest counts as sampled and held.
    """
    own, unknown = device(at.blocks, known.device)
    between = channel(at, known, scenario)
    residual = np.asarray(own.residual + between.port.residual)
    held = np.asarray(own.given - between.port.taken)
    if len(jumps := np.flatnonzero(np.diff(at.blocks.user.tick) > 1)):
        open_j = np.cumsum(_in_blocks(at.blocks, jumps, residual))
        residual, held, unknown = residual - open_j, held + open_j, unknown | {"sample_hold"}
    sums = {"device_kinetic": own.stored, "device_damping": own.dissipated, "sample_hold": held}
    parts = {part: at.ended(np.asarray(each)) for part, each in sums.items()}
    return OfUser(
        at.ended(np.asarray(own.taken)),
        {**parts, **between.parts},
        at.ended(residual),
        between.remainders | unknown,
    )


def _in_blocks(sums: BlockSums, rows: NDArray[np.intp], energy: Array) -> Array:
    """Return by how much an energy grew in each block of some ticks and of those behind them."""
    inside = np.zeros(len(energy), dtype=bool)
    inside[np.searchsorted(sums.user.block_ends, [rows, rows + 1], side="right")] = True
    return np.where(inside, np.diff(energy, prepend=0.0), 0.0)


class Channel(NamedTuple):
    """What is between a device and the port of its user at the server."""

    port: Account  # of the device's port, at the ends of blocks
    parts: Sums  # of the port with its safety limits, and of what lies behind it, at the instants
    remainders: frozenset[str] = frozenset()  # those of the parts


class At(NamedTuple):
    """The energies of a user's blocks at some instants, with those at its port of the server."""

    blocks: BlockSums
    had_ended: NDArray[np.intp]  # so many blocks at each instant
    had_sent: NDArray[np.intp]  # so many whose packets had left
    u_s: Array
    v_s: Array

    def ended(self, sums: Array) -> Array:
        """Return what the blocks had that had ended."""
        return up_to(sums, self.had_ended)

    def sent(self, sums: Array | None = None) -> Array:
        """Return the energy of the packets that had been sent, or what pays for them."""
        sums = self.blocks.user.energy["u_tx"] if sums is None else sums
        return up_to(sums, self.had_sent)

    def own(self) -> Sums:
        """Return the accounts kept by what stands around the port."""
        return {n: self.ended(s) for n, s in accounted(self.blocks.user.accounts).items()}


def channel(at: At, known: User, scenario: Scenario) -> Channel:
    """Return the accounts of one user's channel."""
    if not has_waves(scenario.controller):
        return _without_waves(at)
    return (_strict if scenario.strict else _plain)(at, known)


def _without_waves(at: At) -> Channel:
    """Return the accounts of a controller without waves: the link is what its own leave over."""
    blocks, user = at.blocks, at.blocks.user
    into = user.energy["u_m"] - user.energy["v_m"]
    work = np.sum(user.f_applied * user.xd_m, axis=-1) * user.tick_s
    taken, own = blocks.of_ticks(work) if complete(user) else into, at.own()
    ends = {"device": at.ended(into), "server": at.u_s - at.v_s}
    link = passed([LINK], ends)[LINK.part] - sum_of(own.values())
    parts = {"safety": at.ended(0.0 * taken), **own, LINK.part: link}
    return Channel(Account(taken, into), parts, frozenset([LINK.part] if own else []))


def _port(blocks: BlockSums, known: User) -> tuple[Account, Sums]:
    """Return the account of a wave port with its safety limits, and the parts of both. The sums of
    the master itself give what was taken in ticks that are not on record.
    """
    user, dt, b = blocks.user, blocks.user.tick_s, known.impedance
    f, f_m, xd, u_m, v_m = user.f_applied, user.f_m, user.xd_m, user.u_m, user.v_m
    beside, kept = {}, 0.0 * xd[:, :1]
    if known.master.velocity_filter.in_force:
        kept = np.asarray(dot(f_m - through(wave_force, b, xd, v_m), xd) * dt)
        beside["force_velocity_filter"] = blocks.of_ticks(kept)
    into, on = np.asarray(dot(f, xd) * dt), wave_energy(u_m, dt) - wave_energy(v_m, dt) + kept
    changed = squared(f - f_m) > SAME_N**2
    changed = changed | (squared(u_m - through(wave_u, b, xd, v_m)) > SAME_ROOT_W**2)
    to_waves = blocks.user.energy["u_m"] - blocks.user.energy["v_m"]
    taken = to_waves + blocks.of_ticks(into - on + kept)
    limited = blocks.of_ticks(np.where(changed, into - on, 0.0))
    given = to_waves + sum_of(beside.values())
    return Account(taken, given, dissipated=limited), {**beside, "safety": limited}


def _plain(at: At, known: User) -> Channel:
    """Return the accounts of the plain channel.

    Integrate-and-dump filters and drops in one; there the rate drop has nothing of its own. A link
    includes what is in flight, and what becomes of packets at a server of another period. Where
    parts stand around the port, only the sum of filter, hold and bank is seen in the signals.
    """
    blocks, user = at.blocks, at.blocks.user
    port, of_port = _port(blocks, known)
    parts = {name: at.ended(sums) for name, sums in of_port.items()}
    energies = {n: at.ended(user.energy[n]) for n in ("u_m", "v_m", "v_rx")}
    energies |= {"u_s": at.u_s, "v_s": at.v_s, "u_tx": at.sent(), "u_m_lp": at.sent()}
    if not known.master.filter.means:
        energies["u_m_lp"] = at.ended(blocks.of_ticks(wave_energy(user.u_m_lp, user.tick_s)))
    kept = passed((FILTER, RATE_DROP, LINK_UP, LINK_DOWN, HOLD), energies)
    if not (own := at.own()):
        return Channel(port, parts | kept)
    both = {"filter_and_hold": kept.pop("filter") + kept.pop("hold") - sum_of(own.values())}
    return Channel(port, {**parts, **own, **both, **kept}, frozenset(both))


def _strict(at: At, known: User) -> Channel:
    """Return the accounts of the strict channel. The node has what the force applied did on the
    motion measured, and what the playout gave out and released; packets are what it paid.
    """
    user, work = at.blocks.user, at.blocks.user.energy["device"]
    released = user.accounts.get(RELEASED.name, 0.0 * work)
    energies = {"work": at.ended(work), "v_m": at.ended(user.energy["v_m"])}
    energies |= {"u_tx": at.sent(), "released": at.sent(released)}
    energies |= {"u_s": at.u_s, "v_s": at.v_s}
    parts = {"safety": at.ended(0.0 * work), **passed(passages(known.master), energies)}
    return Channel(Account(work, work), parts)


def passed(found: Sequence[Passage], energies: Sums) -> Sums:
    """Return what blocks leave over of the energies that they name."""
    return {each.part: np.asarray(each.account(energies).residual) for each in found}
