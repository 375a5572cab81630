# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command of Linux that comes nearest to a link: ``tc qdisc ... netem``, and what it lacks."""

import zlib
from functools import lru_cache

import numpy as np

from pmwvc_core.network.distributions import DISTRIBUTIONS, drawn
from pmwvc_core.network.effects import active, amounts
from pmwvc_core.params import LinkParams

PLENTY = 100_000  # packets: no limit to speak of
MOST = 32767  # of a table: four deviations
SCALE = 8192  # of a table entry: one deviation
ENTRIES = 4096


def table_name(params: LinkParams) -> str:
    """Return the name of the table that tc needs for the jitter; empty: none of ours."""
    law = drawn(params)
    if law is None or law.linux or law.half_width:
        return ""
    which = (params.jitter_shape, params.jitter_quantiles, params.trace_file, params.trace_scale)
    number = zlib.crc32(repr(which).encode()) & 0xFFFF
    return f"pmwvc_{params.jitter}_{number:04x}"


@lru_cache(maxsize=16)
def table_of(params: LinkParams) -> tuple[int, ...]:
    """Return the quantiles of the jitter in 1/8192 of a deviation from the mean, 16 bit each."""
    distribution = DISTRIBUTIONS[params.jitter]
    mean, deviation = distribution.moments(params)
    if deviation <= 0.0:
        return (0,)
    found = [distribution.at(params, (k + 0.5) / ENTRIES) for k in range(ENTRIES)]
    values = np.rint([(value - mean) / deviation * SCALE for value in found])
    return tuple(int(value) for value in np.clip(values, -MOST - 1, MOST))


def table_text(params: LinkParams) -> str:
    """Return the text of that table, for ``/usr/lib/tc/NAME.dist``."""
    values = [str(value) for value in table_of(params)]
    rows = [" ".join(values[k : k + 8]) for k in range(0, len(values), 8)]
    return "\n".join([f"# {params.jitter}: quantiles in 1/8192 of a deviation", *rows, ""])


def tc_line(params: LinkParams, *, device: str = "DEV", seed: int | None = None) -> str:
    """Return the command that makes a network interface do as a link."""
    limited = params.rate_limit_bps > 0.0
    limit = params.queue_packets if limited else PLENTY
    words = [f"tc qdisc replace dev {device} root netem limit {limit}", *_delay(params)]
    words += _models(params)[:1]
    for name in ("duplicate", "corrupt", "reorder"):
        if ratio := getattr(params, name):
            words.append(f"{name} {_percents(ratio)}{_related(params, name)}")
    if params.reorder and params.reorder_gap > 1:
        words.append(f"gap {params.reorder_gap}")
    if limited:
        words.append(f"rate {params.rate_limit_bps:.0f}bit {params.rate_overhead_bytes}")
        if params.rate_cell_bytes:
            words.append(f"{params.rate_cell_bytes} {params.rate_cell_overhead_bytes}")
    if params.slot_max_s:
        words.append(f"slot {_ms(params.slot_min_s)} {_ms(params.slot_max_s)}")
        words += [f"packets {params.slot_packets}"] if params.slot_packets else []
        words += [f"bytes {params.slot_bytes}"] if params.slot_bytes else []
    if seed is not None:
        words.append(f"seed {seed}")
    return " ".join(words)


def not_in_tc(params: LinkParams) -> list[str]:
    """Return what of a link the command leaves out or does otherwise, in words."""
    texts = amounts(params)
    left = [texts[record.name] for record in active(params) if not record.linux]
    if len(_models(params)) > 1:
        left.append("all but the first model of loss")
    if params.queue_bytes and params.rate_limit_bps:
        left.append(f"a queue of {params.queue_bytes} bytes")
    if params.keep_order and drawn(params):
        left.append("the order of packets, which jitter changes there")
    related = ("jitter", "loss", "duplicate", "corrupt", "reorder")
    if any(getattr(params, f"{name}_correlation") for name in related):
        left.append("correlation that keeps probabilities and distributions")
    if params.slot_max_s:
        left.append("slots that go on while nothing is sent")
    law = drawn(params)
    if law and not law.half_width and max(table_of(params)) == MOST:
        left.append("the tail beyond four deviations from the mean")
    return left


def _delay(params: LinkParams) -> list[str]:
    law = drawn(params)
    if law is None:
        return [f"delay {_ms(params.delay_s)}"] if params.delay_s else []
    mean_s, deviation_s = law.moments(params)
    size_s = params.jitter_s if law.half_width else deviation_s
    words = [f"delay {_ms(params.delay_s + mean_s)} {_ms(size_s)}{_related(params, 'jitter')}"]
    if not law.half_width:
        words.append(f"distribution {table_name(params) or params.jitter}")
    return words


def _models(p: LinkParams) -> list[str]:
    found = []
    if p.ge_p or p.ge_good:
        found.append(f"loss gemodel {_percents(p.ge_p, p.ge_r, p.ge_bad, p.ge_good)}")
    if p.markov_p13 or p.markov_p14:
        edges = (p.markov_p13, p.markov_p31, p.markov_p32, p.markov_p23, p.markov_p14)
        found.append(f"loss state {_percents(*edges)}")
    if p.loss:
        found.append(f"loss random {_percents(p.loss)}{_related(p, 'loss')}")
    return found


def _related(params: LinkParams, name: str) -> str:
    rho = getattr(params, f"{name}_correlation")
    return f" {_percents(rho)}" if rho else ""


def _percents(*ratios: float) -> str:
    return " ".join(f"{100.0 * ratio:.6g}%" for ratio in ratios)


def _ms(time_s: float) -> str:
    return f"{1e3 * time_s:.6g}ms"
