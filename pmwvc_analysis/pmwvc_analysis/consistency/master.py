# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions within a master's record: differences that rounding does not explain."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_analysis.traces.hand_work import complete, measured, true_motion
from pmwvc_core.law.channel.constants import MEND_S
from pmwvc_core.numeric import Array
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


def missing(text: str, values: Array, known: Array) -> Iterator[str]:
    """Yield in words how far an energy [J] is from all ``known`` ones, beyond rounding."""
    if not values.size or not known.size:
        return
    known = np.sort(known)
    index = np.searchsorted(known, values)
    below = np.abs(values - known[np.maximum(index - 1, 0)])
    above = np.abs(values - known[np.minimum(index, len(known) - 1)])
    gap = np.minimum(below, above)
    worst = int(np.argmax(gap - RELATIVE * np.abs(values)))
    if gap[worst] > 1e-12 + RELATIVE * abs(values[worst]):
        yield f"{text}, {gap[worst]:.3g} J off"


def master(
    user: UserTraces, known: User | None, *, waves: bool, strict: bool, simulated: bool
) -> Iterator[str]:
    """Yield every contradiction in words; a simulated device is where its model leads."""
    if known is not None and complete(user):
        yield from _work(user, known, simulated=simulated)
    if not waves:  # such controllers keep the sums of packets in the places of the waves'
        for kept, sent in (("u_m", "u_tx"), ("v_m", "v_rx")):
            text = f"{user.name}: the energies {kept} and {sent} differ"
            yield from off(text, "J", user.energy[kept], user.energy[sent])
        return
    for name, wave in (("u_m", user.u_m), ("v_m", user.v_m)):
        sums = _blocks(user, power(wave) * user.tick_s / 2.0, user.energy[name])
        yield from off(f"{user.name}: the energy of {name} is not its sum", "J", *sums)
    if known is None or "force_velocity_filter" in user.accounts:  # its velocity is not on record
        return
    port, more, answers = WavePort(known.impedance), 0.0 * user.v_m, ANSWERS & user.accounts.keys()
    u_m = np.asarray(port.u(user.xd_m, user.v_m))
    limited = (np.abs(user.f_applied - user.f_m) > SMALLEST).any(axis=-1)
    if strict:
        if known.master.rises > 1.0 or measured(known.device):  # nor what the port makes of it
            return
        more = np.asarray(port.force(user.xd_m, 0.0 * user.v_m))
        share = _share(user.f_m - port.force(user.xd_m, user.v_m), more)
        more, moves = share[:, np.newaxis] * more, power(more) > SMALLEST
        most = RELATIVE + np.diff(user.tick[moves]) * user.tick_s / MEND_S
        if (np.abs(np.diff(share[moves])) > most).any():
            yield f"{user.name}: F is not of a damping that changes within {MEND_S * 1e3:g} ms"
    elif complete(user):
        u_m = _shortened(user, u_m)
        if not (known.master.filter.means or "position_surplus" in user.accounts):
            carried = np.append(0.0, power(user.u_m_lp) * known.master.frame_s / 2.0)
            text = f"{user.name}: a packet is not the filter's output"
            yield from missing(text, np.diff(user.energy["u_tx"]), carried)
    force = np.asarray(port.force(user.xd_m, user.v_m)) + more
    rows = ~(limited & bool(answers))  # parts that answer a shortened wave change v_m with it
    yield from off(f"{user.name}: F is not b xd - sqrt(2b) v_m", "N", user.f_m, force, rows)
    if strict or (complete(user) and not answers):
        text = f"{user.name}: u_m is not sqrt(2b) xd - v_m, as far as F xd pays for it"
        yield from off(text, "sqrt(W)", user.u_m, u_m)


def _share(beyond: Array, damped: Array) -> Array:
    """Return which share of b xd a force has more than b xd - sqrt(2b) v_m: as a playout is short
    of energy it comes and goes within ``MEND_S``, the same for all axes.
    """
    size = np.maximum(power(damped), np.finfo(float).tiny)
    share = np.clip(np.sum(beyond * damped, axis=-1) / size, 0.0, 1.0)
    return np.where(np.abs(beyond).max(axis=-1) > SMALLEST, share, 0.0)


def _shortened(user: UserTraces, natural: Array) -> Array:
    """Return u_m of every tick: the natural wave, shortened to what v_m and F xd pay for."""
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
