# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The accounts of a session's blocks, summed over its recorded ticks and steps [J].

======================  ==========================================================================
device                  ``plant.devices.device_account``; x and xd are the true motion, behind an
                        encoder that of :mod:`..traces.true_motion`
safety                  ``wave.ledger.port_account``, in ticks that were limited
filter, rate drop,      differences of the energies of u_m, u_m after the filter, u_tx, u_s and of
links, hold             v_s, v_rx, v_m
port filters, position  what velocity filter, bank and position feedback account for themselves
avatar brakes           the heat that the server accounts for
late decoding           (|u_s|^2 - |v_s|^2)/2 less F_s . xd_s: the force of the step before
contacts                what avatars gave less the forces' work on the object: springs, dampers
object                  ``server.cube.object_account``
======================  ==========================================================================

Equations: docs/theory.md 13.5 and 14.3.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget.hand_work import hand_work
from pmwvc_analysis.budget.parts import accounted
from pmwvc_analysis.budget.result import AtFrames, Sums
from pmwvc_analysis.traces.stages import Stage, rows_of
from pmwvc_analysis.traces.sums import UserSums, running, sum_of, up_to
from pmwvc_analysis.traces.true_motion import TrueMotion, complete, measured, true_motion
from pmwvc_core.account import Account, Passage, wave_energy
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.master.port_filters.velocity_filter import force_filter_kept
from pmwvc_core.master.strict_port import RELEASED, passages
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.devices import device_account
from pmwvc_core.scenario.scenario import User
from pmwvc_core.server.avatar_brake import BRAKES
from pmwvc_core.server.cube import object_account
from pmwvc_core.traces import ServerTraces, UserTraces
from pmwvc_core.transport.packet import LINK_DOWN, LINK_UP
from pmwvc_core.wave.ledger import port_account
from pmwvc_core.wave.rates import FILTER, HOLD, RATE_DROP
from pmwvc_core.wave.transform import WavePort

OF_SIGNALS = ("filter_and_hold", "rate_drop")  # what the signals leave to them


def device(sums: UserSums, params: DeviceParams) -> tuple[Account, set[str]]:
    """Return the account of a device, and which of its parts are remainders.

    A hand whose force was not measured is taken to have given what the device shows. Where the
    true motion is unknown, the damping is what the others leave over.
    """
    user = sums.user
    by_hand = bool(np.isfinite(user.f_h).all())
    motion = true_motion(user, params) if measured(params) else _as_recorded(user)
    if motion is None:
        rendered = hand_work(user, params).at(user, sums.time_s).sums
        kinetic = 0.5 * params.mass * np.sum(user.xd_m**2, axis=-1)
        stored = kinetic[sums.ticks] - kinetic[0]
        hand = rendered + stored
        if by_hand and "hand" in user.energy:
            ends = np.searchsorted(user.block_time_s, sums.time_s + 0.001 * user.tick_s)
            hand = up_to(user.energy["hand"], ends)
        seen = Account(hand, rendered, stored)
        return seen._replace(dissipated=seen.residual), {"device_damping"} if by_hand else {"hand"}
    before, after = (motion.x[:-1], motion.xd[:-1]), (motion.x[1:], motion.xd[1:])
    force = user.f_h if by_hand else None
    each = device_account(params, user.tick_s, before, after, force, user.f_applied)
    own = {} if complete(user) else user.energy
    found = Account(
        sums.anchored(each.taken, own.get("hand")),
        sums.anchored(each.given, own.get("device")),
        sums.of_ticks(each.stored),
        sums.of_ticks(each.dissipated),
    )
    if by_hand:
        return found, set()
    return found._replace(taken=found.taken - found.residual), {"hand"}


def _as_recorded(user: UserTraces) -> TrueMotion:
    return TrueMotion(
        np.concatenate([user.x_m, user.x_m[-1:]]), np.concatenate([user.xd_m, user.xd_m[-1:]])
    )


def master(sums: UserSums, known: User, *, waves: bool) -> tuple[Account, Sums]:
    """Return the account of a master's port with its safety limits, and what is kept beside it.

    In a gap of the record the master's own sums hold, and give what was taken there.
    """
    user, dt = sums.user, sums.user.tick_s
    if not waves:
        per_tick = np.sum(user.f_applied * user.xd_m, axis=-1) * dt
        into = sums.anchored(per_tick, user.energy["u_m"] - user.energy["v_m"])
        taken = sums.of_ticks(per_tick) if complete(user) else into
        return Account(taken, into, dissipated=0.0 * taken), {}
    port = WavePort(known.impedance)
    f, f_m, xd, u_m, v_m = user.f_applied, user.f_m, user.xd_m, user.u_m, user.v_m
    beside, kept = {}, 0.0 * xd[:, :1]
    if known.master.velocity_filter.kind == "equivalent":
        kept = np.asarray(force_filter_kept(f_m, xd, v_m, port, dt))
        beside["force_velocity_filter"] = sums.of_ticks(kept)
    each = port_account(f, f_m, xd, (u_m, v_m), port, dt, kept)
    to_waves = _kept_sum(sums, "u_m") - _kept_sum(sums, "v_m")
    taken = sums.of_ticks(each.taken)
    if not complete(user):
        taken = taken + to_waves - sums.of_ticks(each.given - kept)
    given = to_waves + sum_of([0.0 * to_waves, *beside.values()])
    return Account(taken, given, dissipated=sums.of_ticks(each.dissipated)), beside


def _kept_sum(sums: UserSums, wave: str) -> Array:
    """Return the energy of a wave of the ticks, which the master summed up as well."""
    user = sums.user
    return sums.anchored(wave_energy(getattr(user, wave), user.tick_s), user.energy.get(wave))


def channel(
    sums: UserSums, known: User, at_server: list[Array], *, live: bool
) -> dict[str, Array]:
    """Return what stays between the waves of the ticks and those of the server.

    Integrate-and-dump filters and drops in one; there the rate drop has nothing of its own. A link
    includes what is in flight, and what becomes of packets at a server of another period. Where
    parts stand around the port, only the sum of filter and hold is seen in the signals.
    """
    user, (u_s, v_s) = sums.user, at_server
    energies = {name: _kept_sum(sums, name) for name in ("u_m", "v_m")} | {"u_s": u_s, "v_s": v_s}
    energies["u_tx"] = energies["u_m_lp"] = sums.of_blocks(user.energy["u_tx"])
    answer_s = (LIVE if live else AT_ONCE).answer_s
    energies["v_rx"] = sums.of_blocks(user.energy["v_rx"], after_s=answer_s)
    if not known.master.filter.means:
        energies["u_m_lp"] = sums.of_ticks(wave_energy(user.u_m_lp, user.tick_s))
    kept = passed((FILTER, RATE_DROP, LINK_UP, LINK_DOWN, HOLD), energies)
    if not accounted(user.accounts):
        return kept
    own = {
        n: sums.between_blocks(s) for n, s in _around(user, known).items() if n not in OF_SIGNALS
    }
    rest = kept.pop("filter") + kept.pop("hold") - sum_of(list(own.values()))
    return {**own, "filter_and_hold": rest, **kept}


def strict(
    sums: UserSums, known: User, at_server: list[Array], *, live: bool
) -> tuple[Account, dict[str, Array]]:
    """Return the account of a port on the strict channel, and of what lies behind it.

    The node has what the force applied did on the motion measured, and what the playout gave out
    and released; packets are what it paid.
    """
    user, (u_s, v_s) = sums.user, at_server
    moved = np.diff(user.x_m, axis=0, append=user.x_m[-1:])
    work = sums.of_ticks(np.sum(user.f_applied * moved, axis=-1))
    energies = {"work": work, "v_m": _kept_sum(sums, "v_m"), "u_s": u_s, "v_s": v_s}
    energies |= {"u_tx": paid(sums, live=live), "released": released(sums)}
    return Account(work, work, dissipated=0.0 * work), passed(passages(known.master), energies)


def passed(blocks: Sequence[Passage], energies: Sums) -> Sums:
    """Return what stays in blocks that waves pass."""
    return {block.part: np.asarray(block.account(energies).kept) for block in blocks}


def paid(sums: UserSums, *, live: bool) -> Array:
    """Return the energy that the packets of the strict channel were paid with.

    A live block's sum is taken behind the packet that follows the block.
    """
    return sums.of_blocks(sums.user.energy["u_tx"], after_s=np.inf if live else 0.0)


def released(sums: UserSums, *, after_s: float = 0.0) -> Array:
    """Return the energy that the playout of a device passed on beside its wave; zero where it was
    not recorded. Within a block it may have been at any tick: it counts from ``after_s`` on.
    """
    account = sums.user.accounts.get(RELEASED.name)
    if account is None:
        return np.zeros(len(sums.time_s))
    return sums.of_blocks(running(account), after_s=after_s)


def at_frames(user: UserTraces, known: User) -> AtFrames:
    """Return the parts around a port, ``filter_and_hold`` and ``rate_drop`` at the ends of frames,
    where each is known exactly.

    The packet that a frame's filter output becomes is the next one sent, so the last frame is left
    out.
    """
    found = _around(user, known)
    return AtFrames(user.block_time_s[:-1], {name: sums[:-1] for name, sums in found.items()})


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
    left = energy["u_m"] - energy["v_m"] - filtered + energy["v_rx"]
    left = left - sum_of([0.0 * left, *parts.values()])
    found = {**parts, "filter_and_hold": left, "rate_drop": filtered - sent}
    if "bank_low_in" in accounts:
        net = accounts["bank_low_in"] - accounts["bank_low_out"]
        rest = net - filtered + energy["v_rx"] - parts.get("position_spent", 0.0)
        found |= {"filter_and_hold": rest, "bank": left - rest}
    return found


def energy_at(server: ServerTraces, name: str, wave: str) -> Array:
    """Return the energy of one user's waves at the server [J]."""
    sums = server.energy_u_s if wave == "u_s" else server.energy_v_s
    return running(sums[server.users.index(name)])


def into(server: ServerTraces, names: list[str]) -> Array:
    """Return what went into the server at the ports of some users [J]."""
    flows = [energy_at(server, name, "u_s") - energy_at(server, name, "v_s") for name in names]
    return sum_of([np.zeros(len(server.time_s)), *flows])


def server_parts(server: ServerTraces, found: Sequence[Stage], into: Array) -> tuple[Sums, Array]:
    """Return the parts of the server at all its steps, and what they do not explain.

    ``integration`` is what the steps of a sampled coupling leave over. The implicit coupling
    leaves nothing over; there it belongs to the residual. A black box has parts of its own. Each
    step counts with the parameters of its stage.
    """
    power = [
        np.nan_to_num(np.sum(f * xd, axis=-1))
        for f, xd in zip(server.f_s, server.xd_s, strict=True)
    ]
    work = np.cumsum(sum(power) * server.periods_s)
    own, braked = server.accounts, {}
    if BRAKES in own:
        braked, into = {BRAKES: own[BRAKES]}, into - own[BRAKES]
    if found[0].scenario.coupling.black_box:
        port = Account(into, work, dissipated=own["late_decoding"] + own["withheld"])
        box = Account(work, own["contained"], stored=server.potential)
        return {
            **{part: own[part] for part in ("late_decoding", "withheld", "contained")},
            **braked,
            "environment_stored": server.potential,
            "environment_heat": np.asarray(box.residual),
        }, np.asarray(port.residual)
    late, exact = np.zeros(len(into), dtype=bool), np.zeros(len(into), dtype=bool)
    for stage, rows in zip(found, rows_of(found, server.time_s), strict=True):
        late |= rows & stage.scenario.coupling.late
        exact |= rows & stage.scenario.coupling.exact
    port, body = Account(into, _chosen(late, work, into)), _object(server, found)
    heat = server.dissipated - body.dissipated - body.residual
    contacts = Account(port.given, body.taken, server.potential, heat)
    none, residual = np.zeros(len(into)), np.asarray(contacts.residual)
    return {
        **braked,
        "late_decoding": np.asarray(port.kept),
        "integration": _chosen(exact, none, residual),
        "contact_damping": np.asarray(heat),
        "contact_stored": server.potential,
        "object_kinetic": server.kinetic,
        "object_damping": np.asarray(body.dissipated),
    }, np.asarray(body.residual + _chosen(exact, residual, none))


def _chosen(rows: NDArray[np.bool_], there: Array, elsewhere: Array) -> Array:
    """Return a running sum that grows as one of two: ``there`` in some rows, else the other."""
    grows = [np.diff(sums, prepend=0.0) for sums in (there, elsewhere)]
    return np.cumsum(np.where(rows, *grows))


def _object(server: ServerTraces, found: Sequence[Stage]) -> Account:
    """Return the account of the object since the start."""
    none = np.zeros(len(server.time_s))
    if not found[0].scenario.environment.movable:
        return Account(server.kinetic, none, server.kinetic, none)
    force = sum((np.nan_to_num(f) for f in server.f_s), start=np.zeros_like(server.x_o))
    before = np.concatenate([0.0 * force[:1], force[:-1]])
    velocity = np.concatenate([0.0 * server.xd_o[:1], server.xd_o[:-1]])
    taken, heat = none.copy(), none.copy()
    mass = found[0].scenario.server.object_mass
    for stage, rows in zip(found, rows_of(found, server.time_s), strict=True):
        params, motion = stage.scenario.server, stage.scenario.coupling.object_motion
        if params.object_mass != mass and rows.any():  # it goes on with the energy that it had
            velocity[np.argmax(rows)] *= np.sqrt(mass / params.object_mass)
        mass = params.object_mass
        each = object_account(
            params.object_mass,
            params.object_damping,
            server.periods_s[rows, np.newaxis],
            np.diff(server.x_o, axis=0, prepend=server.x_o[:1])[rows],
            velocity[rows],
            (before if motion == "held_before" else force)[rows],
            np.diff(server.kinetic, prepend=0.0)[rows, np.newaxis],
            midpoint=motion == "midpoint",
        )
        taken[rows], heat[rows] = np.ravel(each.taken), np.ravel(each.dissipated)
    return Account(np.cumsum(taken), none, server.kinetic, np.cumsum(heat))
