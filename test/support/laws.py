# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws beside what they must equal: the numbers in them, one after the other."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from pmwvc_core.compiled import compiled

SAME = 1e-12


def numbers(*values: Any) -> list[float]:
    """Return all numbers in states, vectors and arrays, in order."""
    return list(_numbers(values))


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, (tuple, list)):
        for each in value:
            yield from _numbers(each)
    else:
        yield from np.ravel(np.asarray(value, dtype=float)).tolist()


def assert_same(one: Any, other: Any, said: str = "") -> None:
    """Fail where two structures differ by more than rounding."""
    np.testing.assert_allclose(numbers(one), numbers(other), rtol=SAME, atol=SAME, err_msg=said)


def as_written(monkeypatch: Any, **changed: Any) -> None:
    """Have sessions run the laws as they are written, so that a test can change one of them: a
    name is that of a module of the laws and what is changed in it, with ``__`` for the dots.
    """
    for who in ("core.ends.user_end", "core.ends.server_end", "analysis.models.ends"):
        monkeypatch.setattr(f"pmwvc_{who}.unrolled", lambda law, axes: law)  # none is kept
    for name, value in changed.items():
        monkeypatch.setattr(f"pmwvc_core.law.{name.replace('__', '.')}", value)


def in_bulk(driver: Callable[..., Any]) -> Any:
    """Return a function of a test compiled like a law, with the laws that it calls."""
    driver.__module__ = "pmwvc_core.law.driver"
    return compiled(driver)
