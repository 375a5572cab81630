# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions within a master's record: differences that rounding does not explain."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_analysis.traces.hand_work import complete, measured, true_motion
from pmwvc_analysis.traces.holes import gaps
from pmwvc_core.law.channel.constants import MEND_S
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import UserTraces
from pmwvc_core.wave.impedance import WavePort

RELATIVE = 1e-6
SMALLEST = 1e-9
# Accounts of what answers the outgoing wave within the tick: v_m then depends on how far it was
# shortened.
ANSWERS = {"velocity_filter", "local_stored", "bank_low_in"}


def power(waves: Array) -> Array:
    """Return the squared length of each row."""
    return np.asarray(np.sum(waves**2, axis=-1))


def differs(left: Array, right: Array) -> float | None:
    """Return the largest difference where it is more than rounding can explain, else None."""
    if not left.size:
        return None
    gap = float(np.abs(left - right).max())
    size = float(max(np.abs(left).max(), np.abs(right).max()))
    return gap if gap > SMALLEST + RELATIVE * size else None


def off(text: str, unit: str, left: Array, right: Array, rows: Any = ...) -> Iterator[str]:
    """Yield in words by how much two sides of an invariant are off in some rows, if they are."""
    if (gap := differs(left[rows], right[rows])) is not None:
        yield f"{text}, {gap:.3g} {unit} off"


def master(
    user: UserTraces, known: User | None, *, waves: bool, strict: bool, simulated: bool
) -> Iterator[str]:
    """Yield every contradiction in words; a simulated device is where its model leads."""
    if known is not None and complete(user):
        yield from _work(user, known, simulated=simulated)
    if not waves:  # such controllers keep the sums of packets in the places of the waves'
        for kept, sent in (("u_m", "u_tx"), ("v_m", "v_rx")):
            if (gap := differs(user.energy[kept], user.energy[sent])) is not None:
                yield f"{user.name}: the energies {kept} and {sent} differ by {gap:.3g} J"
        return
    for name, wave in (("u_m", user.u_m), ("v_m", user.v_m)):
        sums = _blocks(user, power(wave) * user.tick_s / 2.0, user.energy[name])
        yield from off(f"{user.name}: the energy of {name} is not its sum", "J", *sums)
    if "force_velocity_filter" in user.accounts:  # the velocity in the force, for itself
        return
    if strict and known is not None:
        if not measured(known.device):
            yield from _strict(user, known)
        return
    yield from _port(user)
    if known is not None:
        yield from _force(user, known)
        yield from _filter(user, known)
        if not ANSWERS & user.accounts.keys() and complete(user):
            text = f"{user.name}: u_m is not sqrt(2b) xd - v_m, as far as F xd pays for it"
            yield from off(text, "sqrt(W)", user.u_m, _outgoing(user, known))


def _strict(user: UserTraces, known: User) -> Iterator[str]:
    """Check F = b xd - sqrt(2b) v_m and u_m = sqrt(2b) xd - v_m of the strict channel; F has
    up to all of b xd more, coming and going within ``MEND_S``, as a playout is short of energy.
    """
    if known.master.rises > 1.0:  # with which impedance a tick ran is not on record
        return
    port = WavePort(known.impedance)
    damped = np.asarray(port.force(user.xd_m, 0.0 * user.v_m))
    beyond = user.f_m - port.force(user.xd_m, user.v_m)
    size = np.maximum(power(damped), np.finfo(float).tiny)
    share = np.clip(np.sum(beyond * damped, axis=-1) / size, 0.0, 1.0)  # one for all axes
    asked = np.where(np.abs(beyond).max(axis=-1) > SMALLEST, share, 0.0)[:, np.newaxis] * damped
    yield from _force(user, known, asked)
    moves = power(damped) > SMALLEST
    most = RELATIVE + np.diff(user.tick[moves]) * user.tick_s / MEND_S
    if (np.abs(np.diff(share[moves])) > most).any():
        yield f"{user.name}: F is not of a damping that changes within {MEND_S * 1e3:g} ms"
    u_m = np.asarray(port.u(user.xd_m, user.v_m))
    yield from off(f"{user.name}: u_m is not sqrt(2b) xd - v_m", "sqrt(W)", user.u_m, u_m)


def _limited(user: UserTraces) -> Flags:
    return np.asarray((np.abs(user.f_applied - user.f_m) > SMALLEST).any(axis=-1))


def _port(user: UserTraces) -> Iterator[str]:
    """Check the power of the port where the safety layer let the force through unchanged: the wave
    of a limited force is shortened, and so are those after it that make up the deficit.
    """
    moved = np.sum(user.f_m * user.xd_m, axis=-1)
    waves = (power(user.u_m) - power(user.v_m)) / 2.0
    size = max(float(np.abs(each).max(initial=0.0)) for each in (moved, waves))
    other, limited = np.abs(moved - waves) > SMALLEST + RELATIVE * size, _limited(user)
    behind = np.concatenate([[user.tick[0] > 0], (limited | other)[:-1]])
    behind[gaps(user) + 1] = True
    paid = other & ~limited & ~(behind & (waves < moved))
    text = f"{user.name}: F xd is not (|u|^2 - |v|^2)/2 at the master"
    yield from off(text, "W", moved, waves, paid)


def _force(user: UserTraces, known: User, more: Array | float = 0.0) -> Iterator[str]:
    """Check the force asked for: b xd - sqrt(2b) v_m, and what is more of it [N]. Where parts
    answer a shortened wave v_m is another one.
    """
    rows = ~(_limited(user) & bool(ANSWERS & user.accounts.keys()))
    force = np.asarray(WavePort(known.impedance).force(user.xd_m, user.v_m)) + more
    text = f"{user.name}: F is not sqrt(b/2) (u - v) at the master"
    yield from off(text, "N", user.f_m, force, rows)


def _outgoing(user: UserTraces, known: User) -> Array:
    """Return u_m of every tick: the natural wave, shortened to what v_m and F xd pay for."""
    natural = np.asarray(WavePort(known.impedance).u(user.xd_m, user.v_m))
    more = 2.0 * np.sum((user.f_applied - user.f_m) * user.xd_m, axis=-1)
    changed = (user.f_applied != user.f_m).any(axis=-1)
    ratio, deficit_w = np.ones((len(natural), 1)), 0.0  # as power over a tick
    rows = zip(power(natural).tolist(), more.tolist(), changed.tolist(), strict=True)
    for row, (natural_w, more_w, other) in enumerate(rows):
        if not other and deficit_w == 0.0:
            continue
        budget = natural_w + more_w - deficit_w
        spent = max(budget, 0.0) if budget < natural_w else natural_w
        if budget < natural_w:
            ratio[row] = min(math.sqrt(spent / natural_w), 1.0) if natural_w else 1.0
        deficit_w = max(spent - budget, 0.0)
    return np.asarray(ratio * natural)


def _filter(user: UserTraces, known: User) -> Iterator[str]:
    """Check that packets carry the filter's output of the tick before them.

    The sums of a block are taken before the packet that follows it is sent (virtual time) or after
    (live): all packets fit one of the two. Integrate-and-dump sends the mean of a frame, and a
    feedback that pays may shorten a packet.
    """
    if known.master.filter.means or "position_surplus" in user.accounts:
        return
    first = user.block_ends[:-1]
    inside = (first > 0) & (first < len(user.tick))
    first = first[inside]
    follows = np.diff(user.tick)[first - 1] == 1
    follows &= user.tick[first] % known.master.rate_drop == 0
    sent = np.diff(user.energy["u_tx"])[inside]
    carried = power(user.u_m_lp[first - 1]) * known.master.frame_s / 2.0
    both = follows[:-1] & follows[1:] & (np.diff(first) == known.master.rate_drop)
    before = differs(sent[follows], carried[follows])
    after = differs(sent[:-1][both], carried[1:][both]) if both.any() else before
    if before is not None and after is not None:
        gap = min(before, after)
        yield f"{user.name}: a packet is not the filter's output, {gap:.3g} J off"


def _blocks(user: UserTraces, per_tick: Array, recorded: Array) -> tuple[Array, Array]:
    """Return a sum over whole blocks from the ticks, and as the master kept it."""
    sums = np.concatenate([[0.0], np.cumsum(per_tick)])
    own = np.diff(sums[np.concatenate([[0], user.block_ends])])
    lasted = np.diff(user.block_time_s)
    whole = np.append(user.tick[0] == 0, lasted < 1.5 * np.median(lasted))
    return own[whole], np.diff(recorded, prepend=0.0)[whole]


def _work(user: UserTraces, known: User, *, simulated: bool) -> Iterator[str]:
    """Check the work of both forces against forces and motion, tick by tick."""
    if (motion := true_motion(user, known.device)) is None:
        if simulated and np.isfinite(user.f_h).all():
            yield f"{user.name}: the device is not where its model and the forces recorded lead"
        return
    x = motion.x[:-1]
    for name, force in (("device", user.f_applied), ("hand", user.f_h)):
        if name in user.energy and np.isfinite(force).all():
            per_tick = np.append(np.sum(force[:-1] * np.diff(x, axis=0), axis=-1), 0.0)
            own, recorded = _blocks(user, per_tick, user.energy[name])
            text = f"{user.name}: the work of the {name} is not its sum"
            yield from off(text, "J", own[:-1], recorded[:-1])
