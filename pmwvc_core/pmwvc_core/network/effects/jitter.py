# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Jitter: a delay that differs from packet to packet, drawn or recorded."""

from statistics import NormalDist
from typing import Any

from pmwvc_core.errors import RecordingError
from pmwvc_core.network.delay_trace import DelayTrace, load_delay_trace
from pmwvc_core.network.effects.record import Effect, EffectMaker, LinkEffect
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams

STANDARD_NORMAL = NormalDist()
SLOT = 2  # among the numbers that every packet draws


class UniformJitter(Effect):
    """Add delay_s +- jitter_s, evenly spread."""

    def delay_s(self, fate: Fate) -> float:
        """Return a number from -jitter_s to jitter_s [s]."""
        return float(self.params.jitter_s * (2.0 * self.uniform(fate) - 1.0))


class NormalJitter(Effect):
    """Add a normal distribution of standard deviation jitter_s."""

    def delay_s(self, fate: Fate) -> float:
        """Return a normally distributed number [s]."""
        return float(
            self.params.jitter_s * STANDARD_NORMAL.inv_cdf(max(self.uniform(fate), 1e-17))
        )


class RecordedJitter(Effect):
    """Add the delays of a recording, by the time since the first packet."""

    def configure(self, params: LinkParams) -> None:
        """Read the recording."""
        super().configure(params)
        self._trace = load_delay_trace(params.trace_file, params.trace_scale)

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return the time later by the recorded delay."""
        return due_ns + self._trace.at(fate.time_in_ns - self.begin_ns)


def _amount(params: LinkParams) -> str:
    if params.jitter_s <= 0.0:
        return ""
    return f"jitter ({params.jitter}, {params.jitter_s * 1e3:g} ms)"


def _spread_s(params: LinkParams) -> float:
    return float(params.jitter_s)


def _recorded(params: LinkParams) -> DelayTrace | None:
    """Return the recording; None where the file cannot be read."""
    try:
        return load_delay_trace(params.trace_file, params.trace_scale)
    except RecordingError:
        return None


def _longest_s(params: LinkParams) -> float | None:
    trace = _recorded(params)
    return trace.longest_s if trace else None


def _mean_s(params: LinkParams) -> float:
    trace = _recorded(params)
    return trace.mean_s if trace else 0.0


def _recorded_amount(params: LinkParams) -> str:
    text, trace = f"the delays of {params.trace_file}", _recorded(params)
    if trace is None:
        return text
    mean_ms, longest_ms = 1e3 * trace.mean_s, 1e3 * trace.longest_s
    return f"{text}, {mean_ms:.3g} ms on the mean and {longest_ms:.3g} at most"


def _label(params: LinkParams) -> str:
    return f"{params.jitter} jitter"


def _conflict(params: LinkParams) -> str:
    return "" if params.trace_file else "trace_file is missing: jitter = trace needs a file"


def _check(params: LinkParams) -> None:
    load_delay_trace(params.trace_file, params.trace_scale)


def _record(name: str, words: str, make: EffectMaker, **own: Any) -> LinkEffect:
    """Return the record of one value of ``jitter``."""
    return LinkEffect(
        name=name,
        words=words,
        linear="delay",
        make=make,
        active=lambda params: params.jitter == name,
        spreads=True,
        label=_label,
        off="none",
        **own,
    )


def _drawn(name: str, words: str, make: EffectMaker) -> LinkEffect:
    own = {"parameters": ("jitter", "jitter_s"), "slot": SLOT}
    return _record(name, words, make, spread_s=_spread_s, amount=_amount, **own)


UNIFORM = _drawn("uniform", "The delay is evenly spread.", UniformJitter)
NORMAL = _drawn("normal", "The delay is normally distributed.", NormalJitter)
TRACE = _record(
    "trace",
    "The delay follows a recording.",
    RecordedJitter,
    parameters=("jitter", "trace_file", "trace_scale"),
    random=False,
    spread_s=_longest_s,
    mean_s=_mean_s,
    amount=_recorded_amount,
    conflict=_conflict,
    check=_check,
)
