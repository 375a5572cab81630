# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The accounts of a user's blocks, summed over the recorded ticks [J].

======================  ==========================================================================
device                  ``plant.device.device_account``; x and xd are the true motion, behind an
                        encoder that of :mod:`..traces.hand_work`
safety                  F xd dt less (|u_m|^2 - |v_m|^2) dt/2, in ticks that were limited
filter, rate drop,      differences of the energies of u_m, u_m after the filter, u_tx, u_s and of
links, hold             v_s, v_rx, v_m: the passages of ``controllers.accounts``
port filters, position  what velocity filter, bank and position feedback account for themselves
======================  ==========================================================================

Equations: docs/theory.md 13.5.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.parts import accounted
from pmwvc_analysis.budget.result import Sums, Totals
from pmwvc_analysis.traces.hand_work import complete, hand_work, true_motion
from pmwvc_analysis.traces.holes import gaps
from pmwvc_analysis.traces.sums import UserSums, running, sum_of, up_to
from pmwvc_core.account import Account, Passage, wave_energy
from pmwvc_core.controllers.accounts import FILTER, HOLD, RATE_DROP, RELEASED, passages
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.frame import AT_ONCE, LIVE
from pmwvc_core.numeric import Array, dot, squared
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.device import device_account
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import UserTraces
from pmwvc_core.transport.packet import LINK, LINK_DOWN, LINK_UP
from pmwvc_core.wave.impedance import WavePort

SAME_N, SAME_ROOT_W = 1e-9, 1e-9  # forces and waves closer than this are the same
OF_SIGNALS = ("filter_and_hold", "rate_drop")  # what the signals leave to them


def device(sums: UserSums, params: DeviceParams) -> tuple[Account, set[str]]:
    """Return the account of a device, and which of its parts are remainders.

    A hand whose force was not measured is taken to have given what the device shows, and any hand
    the energy with which the record begins. Where the true motion is unknown, the damping is what
    the others leave over.
    """
    user = sums.user
    by_hand = bool(np.isfinite(user.f_h).all())
    kinetic = 0.5 * params.mass * np.sum(user.xd_m**2, axis=-1)
    brought_j = kinetic[0] if user.tick[0] == 0 else 0.0  # else the hand's own sums have it
    if (motion := true_motion(user, params)) is None:
        rendered = hand_work(user, params).at(user, sums.time_s)[0]
        hand = rendered + kinetic[sums.ticks]
        if by_hand and "hand" in user.energy:
            ends = np.searchsorted(user.block_time_s, sums.time_s + 0.001 * user.tick_s)
            hand = brought_j + up_to(user.energy["hand"], ends)
        seen = Account(hand, rendered, kinetic[sums.ticks])
        return seen._replace(dissipated=seen.residual), {"device_damping"} if by_hand else {"hand"}
    before, after = (motion.x[:-1], motion.xd[:-1]), (motion.x[1:], motion.xd[1:])
    forces = user.f_h if by_hand else None, user.f_applied
    each = device_account(params, user.tick_s, before, after, *forces)
    own = {} if complete(user) else user.energy
    found = Account(  # what the last tick led to is not on record
        brought_j + sums.anchored(each.taken, own.get("hand"), unknown=1),
        sums.anchored(each.given, own.get("device"), unknown=1),
        kinetic[0] + sums.of_ticks(each.stored),
        sums.of_ticks(each.dissipated),
    )
    without_hand = found._replace(taken=found.taken - found.residual)
    return (found, set()) if by_hand else (without_hand, {"hand"})


class Channel(NamedTuple):
    """What is between a device and the port of its user at the server."""

    port: Account  # of the device's port
    parts: Sums  # of the port with its safety limits, and of what lies behind it
    remainders: frozenset[str] = frozenset()  # those of the parts
    frames: Mapping[str, Totals] = MappingProxyType({})  # parts known exactly at frames' ends


def channel(
    sums: UserSums, known: User, at_server: list[Array], scenario: Scenario, *, live: bool
) -> Channel:
    """Return the accounts of one user's channel; ``at_server`` has the energies of u_s and v_s."""
    if not has_waves(scenario.controller):
        return _without_waves(sums, at_server)
    return (_strict if scenario.strict else _plain)(sums, known, at_server, live=live)


def _without_waves(sums: UserSums, at_server: list[Array]) -> Channel:
    """Return the accounts of a controller without waves: the link is what its own leave over."""
    user, (u_s, v_s) = sums.user, at_server
    per_tick = np.sum(user.f_applied * user.xd_m, axis=-1) * user.tick_s
    into = sums.anchored(per_tick, user.energy["u_m"] - user.energy["v_m"])
    taken = sums.of_ticks(per_tick) if complete(user) else into
    own = {n: sums.between_blocks(s) for n, s in accounted(user.accounts).items()}
    link = passed([LINK], {"device": into, "server": u_s - v_s})[LINK.part] - sum_of(own.values())
    parts = {"safety": 0.0 * taken, **own, LINK.part: link}
    port = Account(taken, into, dissipated=parts["safety"])
    return Channel(port, parts, frozenset([LINK.part] if own else []))


def _port(sums: UserSums, known: User) -> tuple[Account, Sums]:
    """Return the account of a wave port with its safety limits, and the parts of both. In a gap of
    the record the master's own sums hold, and give what was taken there.
    """
    user, dt = sums.user, sums.user.tick_s
    port = WavePort(known.impedance)
    f, f_m, xd, u_m, v_m = user.f_applied, user.f_m, user.xd_m, user.u_m, user.v_m
    beside, kept = {}, 0.0 * xd[:, :1]
    if known.master.velocity_filter.in_force:
        kept = np.asarray(dot(f_m - port.force(xd, v_m), xd) * dt)
        beside["force_velocity_filter"] = sums.of_ticks(kept)
    into, on = np.asarray(dot(f, xd) * dt), wave_energy(u_m, dt) - wave_energy(v_m, dt) + kept
    changed = squared(f - f_m) > SAME_N**2
    changed = changed | (squared(u_m - port.u(xd, v_m)) > SAME_ROOT_W**2)
    to_waves = sums.of_wave("u_m") - sums.of_wave("v_m")
    taken = sums.of_ticks(into)
    if not complete(user):
        taken = taken + to_waves - sums.of_ticks(on - kept)
    limited = sums.of_ticks(np.where(changed, into - on, 0.0))
    given = to_waves + sum_of(beside.values())
    return Account(taken, given, dissipated=limited), {**beside, "safety": limited}


def _plain(sums: UserSums, known: User, at_server: list[Array], *, live: bool) -> Channel:
    """Return the accounts of the plain channel.

    Integrate-and-dump filters and drops in one; there the rate drop has nothing of its own. A link
    includes what is in flight, and what becomes of packets at a server of another period. Where
    parts stand around the port, only the sum of filter and hold is seen in the signals.
    """
    user, (u_s, v_s) = sums.user, at_server
    port, parts = _port(sums, known)
    energies = {name: sums.of_wave(name) for name in ("u_m", "v_m")} | {"u_s": u_s, "v_s": v_s}
    energies["u_tx"] = energies["u_m_lp"] = sums.of_blocks(user.energy["u_tx"])
    answer_s = (LIVE if live else AT_ONCE).answer_s
    energies["v_rx"] = sums.of_blocks(user.energy["v_rx"], after_s=answer_s)
    if not known.master.filter.means:
        energies["u_m_lp"] = sums.of_ticks(wave_energy(user.u_m_lp, user.tick_s))
    kept = passed((FILTER, RATE_DROP, LINK_UP, LINK_DOWN, HOLD), energies)
    if not accounted(user.accounts):
        return Channel(port, parts | kept)
    around = _around(user, known)
    own = {n: sums.between_blocks(s) for n, s in around.items() if n not in OF_SIGNALS}
    rest = kept.pop("filter") + kept.pop("hold") - sum_of(own.values())
    remainder = "bank" if "bank_low_in" in user.accounts else "filter_and_hold"
    # The packet that a frame's filter output becomes is the next one sent: none after the last.
    ends_s = user.block_time_s[:-1]
    frames = {name: Totals(ends_s, of[:-1]) for name, of in around.items()}
    parts = {**parts, **own, "filter_and_hold": rest, **kept}
    return Channel(port, parts, frozenset([remainder]), frames)


def _strict(sums: UserSums, known: User, at_server: list[Array], *, live: bool) -> Channel:
    """Return the accounts of the strict channel. The node has what the force applied did on the
    motion measured, and what the playout gave out and released; packets are what it paid.
    """
    user, (u_s, v_s) = sums.user, at_server
    moved = np.diff(user.x_m, axis=0, append=user.x_m[-1:])
    own = user.energy.get("device") if user.tick[0] > 0 or len(gaps(user)) else None
    work = sums.anchored(np.sum(user.f_applied * moved, axis=-1), own, unknown=1)
    energies = {"work": work, "v_m": sums.of_wave("v_m"), "u_s": u_s, "v_s": v_s}
    energies |= {"u_tx": paid(sums, live=live), "released": released(sums)}
    port = Account(work, work, dissipated=0.0 * work)
    return Channel(
        port, {"safety": np.asarray(port.dissipated), **passed(passages(known.master), energies)}
    )


def passed(blocks: Sequence[Passage], energies: Sums) -> Sums:
    """Return what blocks leave over of the energies that they name."""
    return {block.part: np.asarray(block.account(energies).residual) for block in blocks}


def paid(sums: UserSums, *, live: bool) -> Array:
    """Return what packets of the strict channel were paid with; live, they follow their block."""
    return sums.of_blocks(sums.user.energy["u_tx"], after_s=np.inf if live else 0.0)


def released(sums: UserSums, *, after_s: float = 0.0) -> Array:
    """Return the energy that the playout of a device passed on beside its wave; zero where it was
    not recorded. Within a block it may have been at any tick: it counts from ``after_s`` on.
    """
    account = sums.user.accounts.get(RELEASED.name)
    if account is None:
        return np.zeros(len(sums.time_s))
    return sums.of_blocks(running(account), after_s=after_s)


def _around(user: UserTraces, known: User) -> Sums:
    """Return the parts around a port, ``filter_and_hold`` and ``rate_drop`` at the ends of blocks.

    ::

        parts + filter + hold = (u_m^2 - v_m^2 - u_m_lp^2) T_c/2 summed + packets received

    What a bank's low branch took in is what the anti-aliasing filter got, what it gave out came
    from the hold: so there filter and hold are known, and the bank is what is left.
    """
    parts, energy, accounts = accounted(user.accounts), user.energy, user.accounts
    sent = np.concatenate([energy["u_tx"][1:], energy["u_tx"][-1:]])
    filtered = sent
    if not known.master.filter.means:
        ticks = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
        filtered = up_to(np.cumsum(wave_energy(user.u_m_lp, user.tick_s)), ticks)
    left = energy["u_m"] - energy["v_m"] - filtered + energy["v_rx"] - sum_of(parts.values())
    found = {**parts, "filter_and_hold": left, "rate_drop": filtered - sent}
    if "bank_low_in" in accounts:
        net = accounts["bank_low_in"] - accounts["bank_low_out"]
        rest = net - filtered + energy["v_rx"] - parts.get("position_spent", 0.0)
        found |= {"filter_and_hold": rest, "bank": left - rest}
    return found
