# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions within a master's record."""

import math

import numpy as np

from pmwvc_analysis.consistency.numbers import SMALLEST, differs, off
from pmwvc_analysis.traces.hand_work import complete, measured, true_motion
from pmwvc_analysis.traces.stretches import gaps
from pmwvc_core.law.port.strict_master import ASKED
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import UserTraces
from pmwvc_core.wave.impedance import WavePort

# Accounts of what answers the outgoing wave within the tick: v_m then depends on how far it was
# shortened.
ANSWERS = {"velocity_filter", "local_stored", "bank_low_in"}


def master(
    user: UserTraces, known: User | None, *, waves: bool, strict: bool, simulated: bool
) -> list[str]:
    """Return every contradiction in words; a simulated device is where its model leads."""
    found = _work(user, known, simulated=simulated)
    if not waves:
        return found + _without_waves(user)
    found += _wave_sums(user)
    if strict and known is not None:
        return found + _strict(user, known)
    found += _port(user)
    if known is not None and "force_velocity_filter" not in user.accounts:
        found += _force(user, known) + _filter(user, known)
        if not ANSWERS & user.accounts.keys() and complete(user):
            found += _outgoing(user, known)
    return found


def _strict(user: UserTraces, known: User) -> list[str]:
    """Check F = b xd - sqrt(2b) v_m and u_m = sqrt(2b) xd - v_m of the strict channel, where the
    velocity measured is not one of counts; F has ``ASKED`` to all of b xd more in ticks where a
    playout is short of energy.
    """
    if measured(known.device) or "force_velocity_filter" in user.accounts:
        return []
    port = WavePort(known.impedance)
    damped = np.asarray(port.force(user.xd_m, 0.0 * user.v_m))
    beyond = user.f_m - port.force(user.xd_m, user.v_m)
    size = np.maximum(np.sum(damped**2, axis=-1), np.finfo(float).tiny)
    share = np.clip(np.sum(beyond * damped, axis=-1) / size, ASKED, 1.0)  # one for all axes
    asked = np.where(np.abs(beyond).max(axis=-1) > SMALLEST, share, 0.0)[:, np.newaxis] * damped
    u_m, text = port.u(user.xd_m, user.v_m), "u_m is not sqrt(2b) xd - v_m"
    found = off(user.u_m, np.asarray(u_m), f"{user.name}: {text}", "sqrt(W)")
    return _force(user, known, asked) + found


def _limited(user: UserTraces) -> Flags:
    return np.asarray((np.abs(user.f_applied - user.f_m) > SMALLEST).any(axis=-1))


def _port(user: UserTraces) -> list[str]:
    """Check the power of the port where the safety layer let the force through unchanged.

    With a force that was limited the outgoing wave is shortened and the identity does not hold,
    nor does it in the ticks after it that make up the deficit; nor where the velocity in the
    force is filtered for itself.
    """
    if "force_velocity_filter" in user.accounts:
        return []
    power = np.sum(user.f_m * user.xd_m, axis=-1)
    waves = (np.sum(user.u_m**2, axis=-1) - np.sum(user.v_m**2, axis=-1)) / 2.0
    limited = _limited(user)
    size = max(float(np.abs(power).max(initial=0.0)), float(np.abs(waves).max(initial=0.0)))
    off = np.abs(power - waves) > SMALLEST + 1e-6 * size
    changed = limited | off
    behind = np.concatenate([[user.tick[0] > 0], changed[:-1]])
    behind[gaps(user) + 1] = True
    paid = off & ~limited & ~(behind & (waves < power))
    if not paid.any():
        return []
    gap = float(np.abs(power - waves)[paid].max())
    return [f"{user.name}: F xd is not (|u|^2 - |v|^2)/2 at the master, {gap:.3g} W off"]


def _force(user: UserTraces, known: User, more: Array | float = 0.0) -> list[str]:
    """Check the force asked for: b xd - sqrt(2b) v_m, and what is more of it [N]. Where parts
    answer a shortened wave v_m is another one.
    """
    rows = ~(_limited(user) & bool(ANSWERS & user.accounts.keys()))
    force = np.asarray(WavePort(known.impedance).force(user.xd_m, user.v_m)) + more
    text = f"{user.name}: F is not sqrt(b/2) (u - v) at the master"
    return off(user.f_m[rows], force[rows], text, "N")


def _outgoing(user: UserTraces, known: User) -> list[str]:
    """Check u_m in every tick: the natural wave, shortened to what v_m and F xd pay for."""
    natural = np.asarray(WavePort(known.impedance).u(user.xd_m, user.v_m))
    size = np.sum(natural**2, axis=-1)
    more = 2.0 * np.sum((user.f_applied - user.f_m) * user.xd_m, axis=-1)
    changed = (user.f_applied != user.f_m).any(axis=-1)
    ratio, deficit_w = np.ones(len(size)), 0.0  # as power over a tick
    rows = zip(size.tolist(), more.tolist(), changed.tolist(), strict=True)
    for row, (natural_w, more_w, other) in enumerate(rows):
        if not other and deficit_w == 0.0:
            continue
        budget = natural_w + more_w - deficit_w
        spent = max(budget, 0.0) if budget < natural_w else natural_w
        if budget < natural_w:
            ratio[row] = min(math.sqrt(spent / natural_w), 1.0) if natural_w else 1.0
        deficit_w = max(spent - budget, 0.0)
    text = f"{user.name}: u_m is not sqrt(2b) xd - v_m, as far as F xd pays for it"
    return off(user.u_m, ratio[:, np.newaxis] * natural, text, "sqrt(W)")


def _filter(user: UserTraces, known: User) -> list[str]:
    """Check that packets carry the filter's output of the tick before them.

    The sums of a block are taken before the packet that follows it is sent (virtual time) or after
    (live): all packets fit one of the two. Integrate-and-dump sends the mean of a frame, and a
    feedback that pays may shorten a packet.
    """
    if known.master.filter.means or "position_surplus" in user.accounts:
        return []
    first = user.block_ends[:-1]
    inside = (first > 0) & (first < len(user.tick))
    first = first[inside]
    follows = np.diff(user.tick)[first - 1] == 1
    follows &= user.tick[first] % known.master.rate_drop == 0
    sent = np.diff(user.energy["u_tx"])[inside]
    output = user.u_m_lp[first - 1]
    carried = np.sum(output**2, axis=-1) * known.master.frame_s / 2.0
    both = follows[:-1] & follows[1:] & (np.diff(first) == known.master.rate_drop)
    before = differs(sent[follows], carried[follows])
    after = differs(sent[:-1][both], carried[1:][both]) if both.any() else before
    if before is not None and after is not None:
        gap = min(before, after)
        return [f"{user.name}: a packet is not the filter's output, {gap:.3g} J off"]
    return []


def _blocks(user: UserTraces, per_tick: Array, recorded: Array) -> tuple[Array, Array]:
    """Return a sum over whole blocks from the ticks, and as the master kept it."""
    sums = np.concatenate([[0.0], np.cumsum(per_tick)])
    own = np.diff(sums[np.concatenate([[0], user.block_ends])])
    whole = np.ones(len(own), dtype=bool)
    whole[1:] = np.diff(user.block_time_s) < 1.5 * np.median(np.diff(user.block_time_s))
    whole[0] = user.tick[0] == 0
    return own[whole], np.diff(recorded, prepend=0.0)[whole]


def _wave_sums(user: UserTraces) -> list[str]:
    """Check the sums of each block against the waves of its ticks, where no tick is missing."""
    found = []
    for name, wave in (("u_m", user.u_m), ("v_m", user.v_m)):
        per_tick = np.sum(wave**2, axis=-1) * user.tick_s / 2.0
        sums = _blocks(user, per_tick, user.energy[name])
        found += off(*sums, f"{user.name}: the energy of {name} is not its sum", "J")
    return found


def _work(user: UserTraces, known: User | None, *, simulated: bool) -> list[str]:
    """Check the work of both forces against forces and motion, tick by tick."""
    if not complete(user) or known is None:
        return []
    x = user.x_m
    if measured(known.device):
        motion = true_motion(user, known.device)
        if motion is None:
            untrue = simulated and np.isfinite(user.f_h).all()
            text = f"{user.name}: the device is not where its model and the forces recorded lead"
            return [text] if untrue else []
        x = motion.x[:-1]
    moved, found = np.diff(x, axis=0), []
    for name, force in (("device", user.f_applied), ("hand", user.f_h)):
        if name not in user.energy or not np.isfinite(force).all():
            continue
        per_tick = np.append(np.sum(force[:-1] * moved, axis=-1), 0.0)
        own, recorded = _blocks(user, per_tick, user.energy[name])
        text = f"{user.name}: the work of the {name} is not its sum"
        found += off(own[:-1], recorded[:-1], text, "J")
    return found


def _without_waves(user: UserTraces) -> list[str]:
    """Check what such controllers keep in the places of the waves' energies."""
    found = []
    for kept, sent in (("u_m", "u_tx"), ("v_m", "v_rx")):
        if (gap := differs(user.energy[kept], user.energy[sent])) is not None:
            found.append(f"{user.name}: the energies {kept} and {sent} differ by {gap:.3g} J")
    return found
