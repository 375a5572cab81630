# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Code from outside, contained: its answers are checked, and what a coupling fails is solved by
``implicit``, exactly passive from any state. Not here: a step that takes too long.
"""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.law.motion import Body, BodyLaw
from pmwvc_core.law.server.contacts import Avatar, couple
from pmwvc_core.law.vectors import plus, within
from pmwvc_core.numeric import Array
from pmwvc_core.plugins import BadAnswer, Faults

LARGEST_N = 1e6  # more is no force


def signal(value: Any, shape: tuple[int, ...], name: str = "step") -> Array:
    """Return an answer of a call as an array of that shape; BadAnswer where it is none."""
    try:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            raise BadAnswer(f"returned complex numbers from {name}")
        array = np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise BadAnswer(f"returned {type(value).__name__} from {name}") from None
    if array.shape != shape:
        raise BadAnswer(f"returned shape {array.shape} from {name}, not {shape}")
    return array


class Contained(NamedTuple):
    """A coupling's own law, what stands in for it, and what went wrong."""

    law: Any
    stand_in: Any
    faults: Faults


@couple.member(Contained)
def _contained(p: Contained, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Any:
    def usable() -> Any:
        found = couple(p.law, avatars, body, law)
        if all(within(plus(a.f, a.xd), LARGEST_N) for a in found[0] if a.present):
            return found
        raise BadAnswer("returned no usable force or velocity (not finite, or beyond 1e6)")

    if (found := p.faults.guarded(usable, None)) is None:
        p.faults.replaced = True
        found = couple(p.stand_in, avatars, body, law)
    return found
