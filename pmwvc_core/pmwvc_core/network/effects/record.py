# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a link effect, and an effect of another package at work on a link, contained:
where a hook fails, the packet passes without the effect.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.params import LinkParams, Spec
from pmwvc_core.plugins import Faults, Record

# Random numbers over [0, 1) of an effect: of a Fate and an index (0) of those of the same packet.
Uniform = Callable[..., float]


class Effect:
    """An effect at work on one link: hooks in the order in which they are called [ns]."""

    begin_ns = 0  # when the first packet entered the link

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        self.uniform = uniform
        self.configure(params)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; what an effect remembers of packets stays."""
        self.params = params

    def loses(self, fate: Fate) -> Cause | bool:
        """Tell whether a packet is lost on entry; a cause where it is not chance."""
        return False

    def delay_s(self, fate: Fate) -> float:
        """Return what is added to the delay of a packet or copy [s]; the sum is never negative."""
        return 0.0

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return when a packet or copy comes out that would be due at ``due_ns``."""
        return due_ns


@dataclass(frozen=True, kw_only=True)
class LinkEffect(Record):
    """A link effect: its properties, and for a plug-in what makes it. ``linear`` is ``delay``
    where the linear model leaves it out; None where the model must not be asked.
    """

    # for the settings and random numbers of a link; those of the library are at work in the link
    make: Callable[[LinkParams, Uniform], Effect] = Effect
    # the parameter of link.* that switches it on, and the value that switches it off
    switch: tuple[str, Any] = ("effects", "")
    # whether settings switch it on; plug-ins are switched on by link.effects
    active: Callable[[LinkParams], bool] = lambda params: True
    # those that link.effects must give a plug-in, by name, with their ranges
    numbers: Mapping[str, Spec] = field(default_factory=dict)
    random: bool = True  # whether the seed decides what it does
    spreads: bool = False  # whether the delay differs from packet to packet
    # by how much tuning rules have to count the delay longer [s]; None: not known
    spread_s: Callable[[LinkParams], float | None] = lambda params: None
    # what it adds to the delay on the mean [s]
    mean_s: Callable[[LinkParams], float] = lambda params: 0.0
    # it and its amount; what stands in brackets is left out of figures; empty: not mentioned
    amount: Callable[[LinkParams], str] = lambda params: ""
    # what is wrong between settings that are each right; empty where nothing is
    conflict: Callable[[LinkParams], str] = lambda params: ""
    # raises where settings cannot be used, a file for example
    check: Callable[[LinkParams], object] = lambda params: None

    def brief(self, params: LinkParams) -> str:
        """Return the amount for a figure."""
        return self.amount(params).partition(" (")[0]


def _finite(value: Any) -> float:
    seconds = float(value)
    if not math.isfinite(seconds):
        raise ValueError(f"a delay of {seconds} s")
    return seconds


FAILED = object()
# What makes an answer of each hook valid, or raises.
HOOKS: Mapping[str, Callable[[Any], Any]] = {"loses": bool, "delay_s": _finite, "arrives_ns": int}


def contained(effect: Effect, name: str, hook: str, faults: Faults) -> Callable[..., Any]:
    """Return a hook of an effect that answers as if there were no effect where it fails."""
    ask, answer, without = getattr(effect, hook), HOOKS[hook], getattr(Effect, hook)

    def call(*arguments: Any) -> Any:
        found = faults.guarded(lambda: answer(ask(*arguments)), FAILED, name)
        return without(effect, *arguments) if found is FAILED else found

    return call
