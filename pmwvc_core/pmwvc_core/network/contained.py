# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The containment of plug-in effects: where a hook fails, the packet passes without the effect."""

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS, reason
from pmwvc_core.network.effects.record import Effect


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
