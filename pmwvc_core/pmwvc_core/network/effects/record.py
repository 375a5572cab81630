# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a link effect: what makes it, and the properties that other code asks for.

An effect is what a link does to its packets. A link asks those that are active, in the order of
the hooks of :class:`Effect`, and within a hook in the order of the library, plug-ins after it.
Plug-ins are contained: where a hook of theirs fails, the packet passes without the effect.
"""

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS, reason
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.network.streams import Correlated
from pmwvc_core.params import LinkParams, Spec
from pmwvc_core.plugins import Record

# Returns the random numbers of one effect on one link, evenly spread over [0, 1): of the Fate of a
# packet or copy, and of an index that counts those of the same packet, 0 by default.
Uniform = Callable[..., float]


class Effect:
    """An effect at work on one link. Hooks stand in the order in which they are called; each does
    nothing unless a class overrides it. Times are integer nanoseconds.
    """

    begin_ns = 0  # when the first packet entered the link

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        self.uniform = uniform
        self.chain = Correlated()  # of its numbers, where it has a correlation
        self.configure(params)

    def correlated(self, fate: Fate, rho: float) -> float:
        """Return a random number of a packet or copy that depends on the packet before."""
        return self.chain.draw(self.uniform(fate), rho, goes_on=not fate.copy)

    def of_event(self, count: int, index: int = 0) -> float:
        """Return a random number of what happens to the link itself for the count-th time."""
        return self.uniform(Fate(count), index)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; what an effect remembers of packets stays."""
        self.params = params

    def loses(self, fate: Fate) -> Cause | bool:
        """Tell whether a packet is lost on entry; a cause where it is not chance."""
        return False

    def copies(self, fate: Fate) -> int:
        """Return how many extra copies of a packet travel."""
        return 0

    def corrupts(self, fate: Fate) -> float | None:
        """Return where a packet or copy is corrupted, in [0, 1); None: nowhere."""
        return None

    def at_once(self, fate: Fate) -> bool:
        """Tell whether a packet or copy goes without delay."""
        return False

    def departs_ns(self, fate: Fate, ready_ns: int) -> int | None:
        """Return when a packet or copy that is ready leaves; None: it is dropped."""
        return ready_ns

    def delay_s(self, fate: Fate) -> float:
        """Return what is added to the delay of a packet or copy [s]; the sum is never negative."""
        return 0.0

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return when a packet or copy comes out that would be due at ``due_ns``."""
        return due_ns


def made_of(**hooks: Callable[..., Any]) -> type[Effect]:
    """Return an effect with these hooks: functions of the effect and of what a hook is given."""
    return type("LibraryEffect", (Effect,), hooks)


def not_above(params: LinkParams, least: str, most: str) -> str:
    """Return that the least value is above the greatest one; empty where it is not."""
    low, high = getattr(params, least), getattr(params, most)
    return f"{least} = {low:g}: must be 0..{most} = {high:g}" if low > high else ""


@dataclass(frozen=True, kw_only=True)
class LinkEffect(Record):
    """A link effect: what makes it, and its properties.

    ``linear`` is ``delay`` where the linear model leaves the effect out, as every packet takes
    ``delay_s``; None where the model must not be asked.
    """

    make: Callable[[LinkParams, Uniform], Effect]  # for the settings and random numbers of a link
    # the parameter of link.* that switches it on, and the value that switches it off
    switch: tuple[str, Any] = ("effects", "")
    # whether settings switch it on; plug-ins are switched on by link.effects
    active: Callable[[LinkParams], bool] = lambda params: True
    # those that link.effects must give a plug-in, by name, with their ranges
    numbers: Mapping[str, Spec] = field(default_factory=dict)
    # index of its number among the four that every packet draws, and of a copy's behind it; None:
    # a random stream of its own
    slot: int | None = None
    random: bool = True  # whether the seed decides what it does
    linux: bool = False  # whether tc-netem has it
    spreads: bool = False  # whether the delay differs from packet to packet
    # by how much tuning rules have to count the delay longer [s]; None: not known
    spread_s: Callable[[LinkParams], float | None] = lambda params: None
    # what it adds to the delay on the mean [s]
    mean_s: Callable[[LinkParams], float] = lambda params: 0.0
    # it and its amount, for sentences and for the drawing of the loop; empty: not mentioned
    amount: Callable[[LinkParams], str] = lambda params: ""
    label: Callable[[LinkParams], str] = lambda params: ""
    # what is wrong between settings that are each right; empty where nothing is
    conflict: Callable[[LinkParams], str] = lambda params: ""
    # raises where settings cannot be used, a file for example
    check: Callable[[LinkParams], object] = lambda params: None


# An effect of tc-netem, which the linear model leaves out and which adds no delay.
linux_effect = partial(LinkEffect, linear="delay", linux=True, spread_s=lambda params: 0.0)


@dataclass
class EffectFaults:
    """The number of failures of a link's plug-in effects, and the reason of the last one."""

    count: int = 0
    text: str = ""

    def note(self, name: str, error: BaseException) -> None:
        """Count a call that failed."""
        self.count += 1
        self.text = f"link.effects = {name!r} raised {reason(error)}"

    def __str__(self) -> str:
        """Return count and reason."""
        return f"calls without the effect: {self.count}; last: {self.text}"


def _finite(value: Any) -> float:
    seconds = float(value)
    if not math.isfinite(seconds):
        raise ValueError(f"a delay of {seconds} s")
    return seconds


def _fraction(value: Any) -> float | None:
    if value is None:
        return None
    fraction = _finite(value)
    if not 0.0 <= fraction < 1.0:
        raise ValueError(f"a flip at {fraction} of the packet")
    return fraction


ANSWERS: Mapping[str, Callable[[Any], Any]] = MappingProxyType(
    {
        "loses": bool,
        "copies": operator.index,
        "corrupts": _fraction,
        "at_once": bool,
        "departs_ns": lambda value: None if value is None else int(value),
        "delay_s": _finite,
        "arrives_ns": int,
    }
)


def contained(effect: Effect, name: str, hook: str, faults: EffectFaults) -> Callable[..., Any]:
    """Return a hook of an effect that answers as if there were no effect where it fails."""
    ask, answer, without = getattr(effect, hook), ANSWERS[hook], getattr(Effect, hook)

    def call(*arguments: Any) -> Any:
        try:
            return answer(ask(*arguments))
        except PLUGIN_ERRORS as error:  # whatever a plug-in raises
            faults.note(name, error)
            return without(effect, *arguments)

    return call
