# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An independent oracle of the link: the fates of a whole train of packets, computed at once.

Written from docs/links.md, with arrays where the link goes packet by packet: it shares the random
numbers with the link (by their seeds) and nothing else.
"""

import math
import zlib
from dataclasses import dataclass

import numpy as np
from scipy import signal, stats

BLOCK, OWN = 1024, 256


class Numbers:
    """The random numbers of a link, by effect, packet and place."""

    def __init__(self, seed, count):
        self.seed, self.count = tuple(seed), count
        self.luck = np.random.default_rng(self.seed).random((count, 4))

    def of(self, name, place=0):
        """Return number ``place`` of every packet of an effect."""
        key = (*self.seed, zlib.crc32(name.encode()))
        blocks = [
            np.random.default_rng((*key, OWN + place, block)).random(BLOCK)
            for block in range(-(-self.count // BLOCK))
        ]
        return np.concatenate(blocks)[: self.count]


def chained(u, rho):
    """Return evenly spread numbers of a Gaussian chain of correlation rho."""
    if rho == 0.0 or not len(u):
        return u
    z = stats.norm.ppf(u)
    start = [rho * z[0]]
    tail, _ = signal.lfilter([math.sqrt(1.0 - rho * rho)], [1.0, -rho], z[1:], zi=start)
    return stats.norm.cdf(np.concatenate(([z[0]], tail)))


def after(before, u, rho):
    """Return the numbers of copies, each behind its packet in the chain."""
    if rho == 0.0:
        return u
    own = math.sqrt(1.0 - rho * rho) * stats.norm.ppf(u)
    return stats.norm.cdf(rho * stats.norm.ppf(before) + own)


def jitter_s(params, u):
    """Return the jitter of evenly spread numbers, by scipy's distributions."""
    size, shape = params.jitter_s, params.jitter_shape
    if size == 0.0 and params.jitter != "quantiles":
        return np.zeros(len(u))
    if params.jitter == "uniform":
        return stats.uniform(-size, 2.0 * size).ppf(u)
    if params.jitter == "normal":
        return size * stats.norm.ppf(u)
    if params.jitter == "gamma":
        shape = shape or 2.0
        return stats.gamma(shape, scale=size / shape).ppf(u)
    if params.jitter == "lognormal":
        return stats.lognorm(shape or 0.5, scale=size).ppf(u)
    if params.jitter == "pareto":
        law = stats.pareto(shape or 3.0)
        return size * (law.ppf(u) - law.mean()) / law.std()
    assert params.jitter == "quantiles"
    pairs = [word.split(":") for word in params.jitter_quantiles.split()]
    return np.interp(u, [float(p) for p, _ in pairs], [float(x) for _, x in pairs])


def gilbert(params, change, chance):
    """Return which packets the Gilbert-Elliott model loses."""
    bad = np.zeros(len(change), dtype=bool)
    for n in range(len(change) - 1):
        bad[n + 1] = change[n] >= params.ge_r if bad[n] else change[n] < params.ge_p
    return chance < np.where(bad, params.ge_bad, params.ge_good)


def handover(params, numbers, time_s):
    """Return outages, losses and steps of the delay at hand-overs."""
    none = np.zeros(len(time_s), dtype=bool)
    if params.handover_s == 0.0:
        return none, none, np.zeros(len(time_s))
    count = np.floor(time_s / params.handover_s).astype(int)
    drawn = Numbers(numbers.seed, int(count.max()) + 1)
    step, outage, length = (np.append(0.0, drawn.of("handover", k)) for k in range(3))
    since = time_s - count * params.handover_s
    low, high = params.handover_outage_min_s, params.handover_outage_max_s
    out = (count > 0) & (outage[count] < params.handover_outage)
    out &= since < low + (high - low) * length[count]
    near = (count > 0) & (since < params.handover_loss_s)
    near |= params.handover_s - since <= params.handover_loss_s
    lost = near & (numbers.of("handover", 3) < params.handover_loss)
    moved = np.where(count > 0, params.handover_step_s * (2.0 * step[count] - 1.0), 0.0)
    return out, lost, moved


@dataclass
class Verdicts:
    """The fates of all packets; times in ns, due 0 where none."""

    moved_s: np.ndarray

    lost: np.ndarray
    outage: np.ndarray
    due_ns: np.ndarray
    corrupted: np.ndarray
    copied: np.ndarray
    copy_due_ns: np.ndarray


def slots(params, seed, begin_ns, due_ns):
    """Return the first instant of the slots, without limits, at or after each time."""
    if params.slot_max_s == 0.0:
        return due_ns
    most = int((due_ns.max() - begin_ns) * 1e-9 / max(params.slot_min_s, 1e-4)) + 2
    steps_s = params.slot_min_s + (params.slot_max_s - params.slot_min_s) * Numbers(seed, most).of(
        "slots"
    )
    instants = begin_ns + np.cumsum(np.maximum(np.rint(steps_s * 1e9).astype(np.int64), 1000))
    return instants[np.searchsorted(instants, due_ns, side="left")]


def fates(params, seed, time_ns, delay_s=None):
    """Return the fates of packets sent at given times; no order kept, no line.

    ``delay_s`` is the constant delay of each packet where a timeline has ramps.
    """
    delay_s = params.delay_s if delay_s is None else delay_s
    count = len(time_ns)
    numbers = Numbers(seed, count)
    begin_ns = time_ns[0]
    time_s = (time_ns - begin_ns) * 1e-9
    lost = chained(numbers.luck[:, 0], params.loss_correlation) < params.loss
    lost |= gilbert(params, numbers.of("gilbert_elliott"), numbers.of("gilbert_elliott", 1))
    outage, near, moved_s = handover(params, numbers, time_s)
    copied = chained_among(numbers.luck[:, 1], params.duplicate_correlation, ~(lost | near))
    copied = (copied < params.duplicate) & ~(lost | near | outage)
    gone = lost | near | outage
    through = ~gone
    rho = params.jitter_correlation
    u = chained_among(numbers.luck[:, 2], rho, through)
    total_s = delay_s + moved_s + jitter_s(params, u)
    due_ns = time_ns + np.maximum(np.rint(total_s * 1e9), 0).astype(np.int64)
    copy_s = delay_s + moved_s + jitter_s(params, after(u, numbers.luck[:, 3], rho))
    copy_due_ns = time_ns + np.maximum(np.rint(copy_s * 1e9), 0).astype(np.int64)
    flips = chained_among(numbers.of("corruption"), params.corrupt_correlation, through)
    return Verdicts(
        moved_s=moved_s,
        lost=gone,
        outage=outage & ~lost,
        due_ns=np.where(gone, 0, slots(params, seed, begin_ns, due_ns)),
        corrupted=through & (flips < params.corrupt),
        copied=copied,
        copy_due_ns=np.where(copied, slots(params, seed, begin_ns, copy_due_ns), 0),
    )


def chained_among(u, rho, rows):
    """Return chained numbers where only some packets take part in the chain."""
    found = u.copy()
    found[rows] = chained(u[rows], rho)
    return found
