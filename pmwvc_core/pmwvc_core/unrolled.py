# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python runs them quickly, for one number of axes: the law itself, with other globals.
What it calls on vectors has one expression per axis; the laws that it calls are unrolled, too.
Values and the order of additions stay the same, so results have the same bits. Only rows, such as
those of users, may have another number of elements than axes.
"""

import dis
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family

LAWS = ("pmwvc_core.law", "pmwvc_core.plant", "pmwvc_core.simulation")


def relinked(law: Any, stand_in: Callable[[Any], Any]) -> Any:
    """Return a law that calls what stands in for the globals that it names."""
    names = {each.argval for each in dis.get_instructions(law) if each.opname == "LOAD_GLOBAL"}
    used = {name: stand_in(law.__globals__[name]) for name in names & set(law.__globals__)}
    copy = FunctionType(law.__code__, law.__globals__ | used, law.__name__, law.__defaults__)
    copy.__module__, copy.__qualname__ = law.__module__, law.__qualname__
    return copy


def is_law(value: Any) -> bool:
    """Tell whether a global is a law, written as a function."""
    return isinstance(value, FunctionType) and value.__module__.startswith(LAWS)


@cache
def unrolled(law: Any, axes: int) -> Any:
    """Return a law, or a family of laws, for so many axes: takes and returns the same."""
    if isinstance(law, Family):
        return _family(law, axes)
    if law in vectors.BY_AXIS:
        form, joined = vectors.BY_AXIS[law]
        cells = [form.format(a="a", b="b", i=i) for i in range(axes)]
        text = joined.join(cells) if joined else f"({', '.join(cells)},)"
        return eval(f"lambda a{', b' * ('{b}' in form)}: {text}")  # texts of the laws only
    return relinked(law, lambda value: _stand_in(value, axes))


def _stand_in(value: Any, axes: int) -> Any:
    return unrolled(value, axes) if is_law(value) or isinstance(value, Family) else value


def _family(family: Family, axes: int) -> Callable[..., Any]:
    laws: dict[type, Any] = {}

    def call(first: Any, *others: Any) -> Any:
        if (kind := type(first)) not in laws:
            laws[kind] = _stand_in(family.members[kind], axes)
        return laws[kind](first, *others)

    return call
