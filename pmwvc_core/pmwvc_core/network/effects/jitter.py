# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Jitter: a delay that differs from packet to packet, drawn or recorded."""

from collections.abc import Callable
from typing import Any, TypeVar

from pmwvc_core.errors import ParameterError, RecordingError
from pmwvc_core.network.delay_trace import DelayTrace, load_delay_trace
from pmwvc_core.network.distributions import DISTRIBUTIONS, Distribution, drawn, file_conflict
from pmwvc_core.network.effects.record import Effect, LinkEffect, made_of
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams

T = TypeVar("T")
SLOT = 2  # among the numbers that every packet draws


def _jitter_s(effect: Effect, fate: Fate) -> float:
    """Add a quantile, by the packet's random number, of the distribution that ``jitter`` names."""
    p = effect.params
    return float(DISTRIBUTIONS[p.jitter].at(p, effect.correlated(fate, p.jitter_correlation)))


class RecordedJitter(Effect):
    """Do as a recording, by the time since the first packet: lose packets, delay the others."""

    def configure(self, params: LinkParams) -> None:
        """Read the recording."""
        super().configure(params)
        self._trace = _read(params)

    def loses(self, fate: Fate) -> bool:
        """Tell whether what was sent then was lost."""
        return self._trace.lost(fate.time_in_ns - self.begin_ns)

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return the time later by the recorded delay."""
        return due_ns + self._trace.at(fate.time_in_ns - self.begin_ns)


def _read(params: LinkParams) -> DelayTrace:
    return load_delay_trace(params.trace_file, params.trace_scale, params.trace_column)


def _known(ask: Callable[[LinkParams], T], params: LinkParams) -> T | None:
    """Return an answer; None where a file or text that it needs cannot be read."""
    try:
        return ask(params)
    except (RecordingError, ParameterError):
        return None


def _moments(params: LinkParams) -> tuple[float, float] | None:
    """Return mean and deviation of the jitter [s], if known."""
    return _known(DISTRIBUTIONS[params.jitter].moments, params)


def _amount(params: LinkParams) -> str:
    if DISTRIBUTIONS[params.jitter].sized:
        rho = params.jitter_correlation
        related = f", correlation {rho:g}" if rho else ""
        return f"jitter ({params.jitter}, {params.jitter_s * 1e3:g} ms{related})"
    moments = _moments(params)
    if moments is None:
        return f"jitter ({params.jitter})"
    mean_ms, deviation_ms = (1e3 * each for each in moments)
    return f"jitter ({params.jitter}: mean {mean_ms:.3g} ms, deviation {deviation_ms:.3g} ms)"


def _spread_s(params: LinkParams) -> float | None:
    """Return by how much the delay is usually longer: half-width or mean and deviation [s]."""
    if DISTRIBUTIONS[params.jitter].half_width:
        return float(params.jitter_s)
    moments = _moments(params)
    return sum(moments) if moments else None


def _recorded_amount(params: LinkParams) -> str:
    text, trace = f"the delays of {params.trace_file}", _known(_read, params)
    if trace is None:
        return text
    mean_ms, longest_ms = 1e3 * trace.mean_s, 1e3 * trace.longest_s
    lost = f", {trace.lost_ratio:.3g} of the packets lost" if trace.lost_ratio else ""
    return f"{text}, {mean_ms:.3g} ms on the mean and {longest_ms:.3g} at most{lost}"


def _record(name: str, words: str, **own: Any) -> LinkEffect:
    """Return the record of one value of ``jitter``."""
    return LinkEffect(
        name=name,
        words=words,
        linear="delay",
        spreads=True,
        label=lambda params: f"{params.jitter} jitter",
        **own,
    )


def _drawn(name: str, distribution: Distribution) -> LinkEffect:
    return _record(
        name,
        f"The delay is {distribution.words}.",
        make=made_of(delay_s=_jitter_s),
        active=lambda params: params.jitter == name and drawn(params) is not None,
        slot=SLOT,
        linux=True,
        spread_s=_spread_s,
        mean_s=lambda params: (_moments(params) or (0.0, 0.0))[0],
        amount=_amount,
        conflict=distribution.conflict,
        check=distribution.check,
    )


DRAWN = tuple(_drawn(name, distribution) for name, distribution in DISTRIBUTIONS.items())
TRACE = _record(
    "trace",
    "The delay follows a recording.",
    make=RecordedJitter,
    active=lambda params: params.jitter == "trace",
    random=False,
    spread_s=lambda params: trace.longest_s if (trace := _known(_read, params)) else None,
    mean_s=lambda params: trace.mean_s if (trace := _known(_read, params)) else 0.0,
    amount=_recorded_amount,
    conflict=file_conflict,
    check=_read,
)
