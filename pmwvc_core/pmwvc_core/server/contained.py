# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Answers of code from outside, checked."""

from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.plugins import BadAnswer

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
