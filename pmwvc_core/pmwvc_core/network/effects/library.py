# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The effects of the library: what switches each on, its amounts, conflicts and means.

What they do to a packet is :mod:`pmwvc_core.network.link`.
"""

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from pmwvc_core.errors import ParameterError, RecordingError, refusal
from pmwvc_core.network.delay_trace import recording_of
from pmwvc_core.network.distributions import DISTRIBUTIONS, Distribution, drawn, file_conflict
from pmwvc_core.network.draws import gilbert_loss
from pmwvc_core.network.effects.record import LinkEffect
from pmwvc_core.network.presets import timeline_of
from pmwvc_core.params import LinkParams

T = TypeVar("T")


def _handover_loss(params: LinkParams) -> float:
    """Return which part of the packets is lost by hand-overs on the mean."""
    outage_s = 0.5 * (params.handover_outage_min_s + params.handover_outage_max_s)
    around_s = min(2.0 * params.handover_loss_s, params.handover_s)
    lost_s = params.handover_outage * outage_s + params.handover_loss * around_s
    return min(lost_s / params.handover_s, 1.0)


def _not_above(least: str, most: str, params: LinkParams) -> str:
    """Return that the least value is above the greatest one; empty where it is not."""
    low, high = getattr(params, least), getattr(params, most)
    return f"{least} = {low:g}: must be 0..{most} = {high:g}" if low > high else ""


def _slot_wait_s(params: LinkParams) -> float:
    """Return the mean time to the next slot from any time [s]: E[L^2] / (2 E[L])."""
    low, high = params.slot_min_s, params.slot_max_s
    return (low * low + low * high + high * high) / (3.0 * (low + high))


def _known(ask: Callable[[LinkParams], T], params: LinkParams) -> T | None:
    """Return an answer; None where a file or text that it needs cannot be read."""
    try:
        return ask(params)
    except (RecordingError, ParameterError):
        return None


def _moments(params: LinkParams) -> tuple[float, float] | None:
    """Return mean and deviation of the jitter [s], if known."""
    return _known(DISTRIBUTIONS[params.jitter].moments, params)


def _jitter_amount(params: LinkParams) -> str:
    if DISTRIBUTIONS[params.jitter].sized:
        rho = params.jitter_correlation
        related = f", correlation {rho:g}" if rho else ""
        return f"{params.jitter} jitter ({params.jitter_s * 1e3:g} ms{related})"
    moments = _moments(params)
    if moments is None:
        return f"{params.jitter} jitter"
    mean_ms, deviation_ms = (1e3 * each for each in moments)
    return f"{params.jitter} jitter (mean {mean_ms:.3g} ms, deviation {deviation_ms:.3g} ms)"


def _recorded_amount(params: LinkParams) -> str:
    trace, text = _known(recording_of, params), params.trace_file
    if trace is not None:
        mean_ms, longest_ms = 1e3 * trace.mean_s, 1e3 * trace.delays_s[-1]
        text += f": {mean_ms:.3g} ms on the mean, at most {longest_ms:.3g}"
        text += f", {100.0 * trace.lost_ratio:.3g} % lost" if trace.lost_ratio else ""
    return f"recorded delays ({text})"


# Left out by the linear model, without a delay.
_undelayed = partial(LinkEffect, linear="delay", spread_s=lambda p: 0.0)
_jitter = partial(LinkEffect, linear="delay", spreads=True)


def _drawn(name: str, law: Distribution) -> LinkEffect:
    return _jitter(
        name=name,
        active=lambda p: p.jitter == name and drawn(p) is not None,
        # usually longer by the half-width, or by mean and deviation
        spread_s=lambda p: (
            float(p.jitter_s)
            if law.half_width
            else (sum(found) if (found := _moments(p)) else None)
        ),
        mean_s=lambda p: (_moments(p) or (0.0, 0.0))[0],
        amount=_jitter_amount,
        conflict=law.conflict,
        check=law.check,
    )


TRACE_NAME = "trace"
TRACE = _jitter(
    name=TRACE_NAME,
    active=lambda p: p.jitter == TRACE_NAME,
    random=False,
    spread_s=lambda p: trace.delays_s[-1] if (trace := _known(recording_of, p)) else None,
    mean_s=lambda p: trace.mean_s if (trace := _known(recording_of, p)) else 0.0,
    amount=_recorded_amount,
    conflict=file_conflict,
    check=recording_of,
)
ORDER = _undelayed(name="order", linear="order", random=False)
LIBRARY = (
    _undelayed(
        name="loss",
        active=lambda p: p.loss > 0.0,
        amount=lambda p: f"loss of {p.loss * 100.0:.3g} %",
    ),
    _undelayed(
        name="gilbert_elliott",
        active=lambda p: p.ge_p > 0.0 or p.ge_good > 0.0,
        amount=lambda p: f"bursts of loss of {gilbert_loss(p) * 100.0:.3g} %",
    ),
    LinkEffect(  # at hand-overs the delay steps and packets are lost
        name="handover",
        linear="delay",
        active=lambda p: p.handover_s > 0.0,
        spreads=True,
        spread_s=lambda p: float(p.handover_step_s),
        amount=lambda p: (
            f"a hand-over every {p.handover_s:g} s (+-{p.handover_step_s * 1e3:g} ms; about "
            f"{_handover_loss(p) * 100.0:.2g} % of the packets lost)"
        ),
        conflict=partial(_not_above, "handover_outage_min_s", "handover_outage_max_s"),
    ),
    _undelayed(
        name="duplication",
        active=lambda p: p.duplicate > 0.0,
        amount=lambda p: f"duplication of {p.duplicate * 100.0:.3g} %",
    ),
    _undelayed(
        name="corruption",
        active=lambda p: p.corrupt > 0.0,
        amount=lambda p: f"corruption of {p.corrupt * 100.0:.3g} %",
    ),
    _undelayed(  # some packets are sent at once and overtake others
        name="reordering",
        active=lambda p: p.reorder > 0.0,
        spreads=True,
        amount=lambda p: f"reordering of {p.reorder * 100.0:.3g} %",
        conflict=lambda p: (
            f"reorder = {p.reorder:g}: nothing is reordered unless keep_order is false"
            if p.keep_order
            else ""
        ),
    ),
    LinkEffect(
        name="rate_limit",
        switch=("rate_limit_bps", 0),
        active=lambda p: p.rate_limit_bps > 0.0,
        random=False,
        amount=lambda p: f"rate limit of {p.rate_limit_bps / 1e3:.4g} kbit/s",
    ),
    _undelayed(
        name="delay",
        random=False,
        mean_s=lambda p: float(p.delay_s),
    ),
    LinkEffect(
        name="schedule",
        linear="delay",
        active=lambda p: bool(p.schedule.strip()),
        spreads=True,
        amount=lambda p: f"timeline ({p.schedule})",
        conflict=lambda p: refusal(timeline_of, p.schedule),
        check=lambda p: timeline_of(p.schedule),
    ),
    *(_drawn(name, law) for name, law in DISTRIBUTIONS.items()),
    TRACE,
    _undelayed(  # packets come out only in slots, several at once
        name="slots",
        active=lambda p: p.slot_max_s > 0.0,
        spreads=True,
        spread_s=lambda p: float(p.slot_max_s),
        mean_s=_slot_wait_s,
        amount=lambda p: f"slots {p.slot_min_s * 1e3:g} to {p.slot_max_s * 1e3:g} ms apart",
        conflict=partial(_not_above, "slot_min_s", "slot_max_s"),
    ),
    ORDER,
)
