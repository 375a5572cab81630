# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Answers of code from outside, checked. Not here: a step that takes too long."""

from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.law.motion import Body, BodyLaw
from pmwvc_core.law.server.contacts import Avatar, couple
from pmwvc_core.law.vectors import plus, within
from pmwvc_core.numeric import Array
from pmwvc_core.plugins import BadAnswer, refused

LARGEST_N = 1e6  # more is no force
Step = tuple[tuple[Avatar, ...], Body, float, bool]


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


class OutsideCoupling(NamedTuple):
    """The law of another package's coupling, and its name."""

    law: Any
    name: str


@couple.member(OutsideCoupling)
def checked(p: OutsideCoupling, avatars: tuple[Avatar, ...], body: Body, law: BodyLaw) -> Step:
    """Step the coupling; a step that it fails ends the session: ParameterError with the reason."""
    with refused(f"server.coupling = {p.name!r}", cannot_be="stepped"):
        found: Step = couple(p.law, avatars, body, law)
        if all(within(plus(a.f, a.xd), LARGEST_N) for a in found[0] if a.present):
            return found
        raise BadAnswer("it returned no usable force or velocity (not finite, or beyond 1e6)")
