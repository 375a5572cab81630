# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Jitter: a delay that differs from packet to packet, drawn or recorded."""

from statistics import NormalDist

from pmwvc_core.errors import RecordingError
from pmwvc_core.network.delay_trace import DelayTrace, load_delay_trace
from pmwvc_core.network.effects.record import Effect, LinkEffect
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


UNIFORM = LinkEffect(
    name="uniform",
    words="The delay is evenly spread.",
    linear="delay",
    make=UniformJitter,
    parameters=("jitter", "jitter_s"),
    active=lambda params: params.jitter == "uniform",
    slot=SLOT,
    spreads=True,
    spread_s=_spread_s,
    amount=_amount,
    label=_label,
    off="none",
)
NORMAL = LinkEffect(
    name="normal",
    words="The delay is normally distributed.",
    linear="delay",
    make=NormalJitter,
    parameters=("jitter", "jitter_s"),
    active=lambda params: params.jitter == "normal",
    slot=SLOT,
    spreads=True,
    spread_s=_spread_s,
    amount=_amount,
    label=_label,
    off="none",
)
TRACE = LinkEffect(
    name="trace",
    words="The delay follows a recording.",
    linear="delay",
    make=RecordedJitter,
    parameters=("jitter", "trace_file", "trace_scale"),
    active=lambda params: params.jitter == "trace",
    random=False,
    spreads=True,
    spread_s=_longest_s,
    mean_s=_mean_s,
    amount=_recorded_amount,
    label=_label,
    off="none",
    conflict=_conflict,
    check=_check,
)
