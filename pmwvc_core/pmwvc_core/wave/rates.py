# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Between tick rate and packet rate: anti-aliasing filter with rate drop, and hold (App. A, B).

The filter takes the outgoing wave of every tick, and a packet is what it gives at a frame start. A
packet v_i that comes back stands for M ticks, so it brings the energy |v_i|^2 M T_c / 2; the hold,
zero-order or delayed first-order, expands it to them. On floats or on arrays ``(runs, dof)``.

What arrives is given out as :class:`Latest`, on the plain and on the zeroing channel.

Coefficients come from :mod:`pmwvc_core.wave.design.filter_design`; what the rate drop makes of
them is judged in :mod:`pmwvc_core.wave.design.aliasing`.

Equations: docs/theory.md 2.1, 2.5, 3.1, 3.4.
"""

from collections.abc import Callable, Mapping
from typing import Protocol

from pmwvc_core.account import Passage
from pmwvc_core.numeric import Flag, Value, exponential
from pmwvc_core.params import FilterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.cascade import Cascade
from pmwvc_core.wave.design.filter_design import design, pole_of

FILTER = Passage("filter", ("u_m",), ("u_m_lp",))
RATE_DROP = Passage("rate_drop", ("u_m_lp",), ("u_tx",))
HOLD = Passage("hold", ("v_rx",), ("v_m",))


class Stage(Protocol):
    """One kind of filter with the rate drop behind it."""

    def step(self, u: Value) -> Value:
        """Take the wave of one fast tick; return the filtered one."""

    def sample(self) -> Value:
        """Return what a packet carries."""


class _Passing(Stateful):
    """No filter: the packet is the wave of the last tick."""

    SIGNALS = "_u"

    def __init__(self) -> None:
        self._u: Value = 0.0

    def step(self, u: Value) -> Value:
        self._u = u
        return u

    def sample(self) -> Value:
        return self._u


class _FirstOrder(Stateful):
    """y+ = p y + (1-p) u, y = 0 at first; the output after a tick already holds that tick."""

    SIGNALS = "_y"

    def __init__(self, p: Value) -> None:
        self._p = p
        self._rest = 1.0 - p
        self._y: Value = 0.0

    def step(self, u: Value) -> Value:
        self._y = y = self._rest * u + self._p * self._y
        return y

    def sample(self) -> Value:
        return self._y


class _IntegrateAndDump(Stateful):
    """The mean over the frame: the integral of the wave over M ticks, divided by their duration.

    (mean)^2 M <= sum of squares (Cauchy-Schwarz), so at every frame end no more energy has been
    sent than has come in, whatever the signal. A frame that lost ticks is still divided by M,
    which keeps both the integral and the bound; a longer one by its own number.
    """

    SIGNALS = "_sum"
    MEMORY = "_ticks"

    def __init__(self, rate_drop: int) -> None:
        self._rate_drop = rate_drop
        self._sum: Value = 0.0
        self._ticks = 0

    def step(self, u: Value) -> Value:
        self._sum = self._sum + u
        self._ticks += 1
        return self._mean()

    def sample(self) -> Value:
        mean = self._mean()
        self._sum = 0.0
        self._ticks = 0
        return mean

    def _mean(self) -> Value:
        return self._sum / (self._ticks if self._ticks > self._rate_drop else self._rate_drop)


STAGES: Mapping[str, Callable[[FilterParams, float, int], Stage]] = {
    "none": lambda params, tick_s, rate_drop: _Passing(),
    "first_order": lambda params, tick_s, rate_drop: _FirstOrder(
        exponential(-pole_of(params) * tick_s)
    ),
    "butterworth": lambda params, tick_s, rate_drop: Cascade(design(params, tick_s=tick_s)),
    "integrate_and_dump": lambda params, tick_s, rate_drop: _IntegrateAndDump(rate_drop),
}


class AntiAliasing(Stateful):
    """Filter of the outgoing wave and drop from the tick rate to the packet rate.

    ``step`` is called once per fast tick, ``sample`` at each frame start: it returns the filter's
    output after the last tick. With ``integrate_and_dump`` ``sample`` also begins the next frame,
    and ``step`` returns the packet as far as it has grown. All states start at zero.

    Parameters
    ----------
    params
        Which filter; numbers may be ``(runs, 1)``.
    rate_drop
        M, ticks per frame.
    """

    BLOCKS = "_stage"

    def __init__(self, params: FilterParams, *, tick_s: float, rate_drop: int) -> None:
        stage = STAGES[params.kind](params, tick_s, rate_drop)
        self._stage = stage
        self.step = stage.step  # bound once: one call less per tick
        self.sample = stage.sample


class Carrier(Protocol):
    """A packet, as far as it carries a wave."""

    wave: Value  # [sqrt(W)]


class Latest(Stateful):
    """The newest wave that has arrived, given out at every step until a newer one comes.

    Holding spends energy that did not arrive where packets fail to come. With ``once`` (the
    zeroing channel) a wave counts for one step, and where none has come the wave is zero: given
    out for one step of the length that its packet stands for, it brings no more energy than the
    packet carried, whatever is lost, late, repeated or out of order. The displacement of what did
    not come in time is lost.

    Attributes
    ----------
    waits, short
        Whether nothing has come for long, or energy lacks: never; see :class:`.playout.Playout`.
    """

    MEMORY = "_packet _fresh"
    waits: bool = False
    short: Flag = False

    def __init__(self, *, once: bool = False) -> None:
        self._once = once
        self._packet: Carrier | None = None
        self._fresh = False

    def begin(self) -> None:
        """Begin anew with the newest wave: the peer placed its position by it."""

    def pass_by(self, lasted_s: float) -> None:
        """Let time go by without steps [s]: the newest wave stays."""

    def spared(self, h: float, *, wanted: Flag) -> Value:
        """Return the energy that passes on in ``h`` seconds [J]: none is kept."""
        return 0.0

    def add(self, packet: Carrier) -> None:
        """Take a newer packet in, with its wave as a float or ``(..., dof)``."""
        self._packet, self._fresh = packet, True

    def step(self, h: float) -> Value:
        """Return the wave of the next ``h`` seconds [sqrt(W)]; zero before the first."""
        if self._packet is None:
            return 0.0
        fresh, self._fresh = self._fresh, False
        wave = self._packet.wave
        return wave if fresh or not self._once else 0.0 * wave


class Hold(Stateful):
    """Expand one packet to the ticks of its frame (App. B, Eq. 43-54, indices corrected).

    ``zoh``: v_m = v_i. ``foh``: v_m = v_{i-1} + (v_i - v_{i-1}) j/M for the ticks j = 1..M after
    the load, where v_{-1} = 0: a start value other than zero would be energy that was never sent.

    A packet that comes early starts its ramp at the value reached, so the output never jumps. That
    is passive: with E = T_c (M-1)/4 v_m^2 as the energy stored at the instant of a load, a frame
    of any number of ticks up to M gives out no more than the packet brings and E loses (for a
    whole frame this is the closed form of the equation).

    After M ticks the output stays at v_i until the next load. This hold-last spends energy that
    did not arrive: whoever owns the link has to watch the frames, not the hold.

    Parameters
    ----------
    ticks
        M, the number of ticks a packet stands for.
    """

    SIGNALS = "_start _target _value"
    MEMORY = "_done"
    __slots__ = ("_done", "_start", "_target", "_value", "ticks")

    def __init__(self, kind: str, *, ticks: int) -> None:
        if kind not in ("zoh", "foh"):
            raise ValueError(f"hold = {kind!r}: must be one of zoh, foh")
        self.ticks = ticks if kind == "foh" else 1  # a ramp of one tick is a zero-order hold
        self._start: Value = 0.0
        self._target: Value = 0.0
        self._value: Value = 0.0
        self._done = 0

    def load(self, v: Value) -> None:
        """Begin a frame with the packet v [sqrt(W)], float or ``(..., dof)``."""
        self._start = self._value
        self._target = v
        self._done = 0

    def step(self) -> Value:
        """Return the wave of the next tick [sqrt(W)]."""
        self._done = done = self._done + 1
        if done < self.ticks:
            ratio = done / self.ticks
            self._value = self._start + (self._target - self._start) * ratio
        else:
            self._value = self._target
        return self._value
