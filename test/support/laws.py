# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws beside what they must equal: the numbers in them, one after the other."""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from pmwvc_core.compiled import compiled
from pmwvc_core.unrolled import unrolled

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


def alter_laws(monkeypatch: Any, **changed: Any) -> None:
    """Have sessions link the laws anew, with changes: a name is that of a module of the laws and
    what is changed in it, with ``__`` for the dots.
    """
    for name, value in changed.items():
        monkeypatch.setattr(f"pmwvc_core.law.{name.replace('__', '.')}", value)
    anew = cache(unrolled.__wrapped__)  # what was linked before has the laws as they were
    for who in (
        "core.unrolled",
        "core.ends.user_end",
        "core.ends.server_end",
        "analysis.models.ends",
    ):
        monkeypatch.setattr(f"pmwvc_{who}.unrolled", anew)


def in_bulk(driver: Callable[..., Any]) -> Any:
    """Return a function of a test compiled like a law, with the laws that it calls."""
    driver.__module__ = "pmwvc_core.law.driver"
    return compiled(driver)
