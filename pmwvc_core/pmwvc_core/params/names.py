# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Dotted names: the parameters of nested dataclasses by one name each, like ``filter.kind``; and
parameters that are texts of what happens when.

A field of a group is named ``prefix.field``, a field of a nested group ``prefix.group.field``; an
empty prefix adds nothing. A group's own parameters come before those of its nested groups.
"""

import dataclasses
import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from operator import attrgetter
from typing import Any, TypeVar

from pmwvc_core.errors import ParameterError
from pmwvc_core.params.fields import Spec, groups, specs

P = TypeVar("P")


def joined(prefix: str, name: str) -> str:
    """Return a name below a prefix."""
    return f"{prefix}.{name}" if prefix else name


def leaves(prefix: str, kind: type) -> dict[str, Spec]:
    """Return the declaration of every parameter of a dataclass by dotted name."""
    found = {joined(prefix, name): spec for name, spec in specs(kind).items()}
    for name, nested_kind in groups(kind).items():
        found |= leaves(joined(prefix, name), nested_kind)
    return found


def flattened(prefix: str, owner: Any) -> dict[str, Any]:
    """Return the value of every parameter of a dataclass by dotted name."""
    return {joined(prefix, path): attrgetter(path)(owner) for path in leaves("", type(owner))}


def replaced(owner: P, path: str, value: Any) -> P:
    """Return a dataclass with the parameter at a dotted path changed; else ParameterError."""
    head, _, rest = path.partition(".")
    if rest:
        value = replaced(getattr(owner, head), rest, value)
    else:
        value = specs(type(owner))[head].converted(value)
    return dataclasses.replace(owner, **{head: value})  # type: ignore[type-var]


def assembled(prefix: str, kind: type[P], given: Mapping[str, Any]) -> P:
    """Build a dataclass from values by dotted name, or defaults; where a group refuses them,
    ParameterError with the full name of every parameter that begins a conflict.
    """
    fields = {
        name: given[joined(prefix, name)] for name in specs(kind) if joined(prefix, name) in given
    }
    for name, nested_kind in groups(kind).items():
        fields[name] = assembled(joined(prefix, name), nested_kind, given)
    try:
        return kind(**fields)
    except ParameterError as error:
        names = "|".join(specs(kind))
        named = re.sub(rf"(^|; )(?=({names}) = )", rf"\1{joined(prefix, '')}", str(error))
        start = "" if named.startswith(f"{prefix}.") or not prefix else f"{prefix}: "
        raise ParameterError(f"{start}{named}") from None


def nested(flat_values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted name as nested dictionaries."""
    found: dict[str, Any] = {}
    for name, value in flat_values.items():
        *path, leaf = name.split(".")
        level = found
        for part in path:
            level = level.setdefault(part, {})
        level[leaf] = value
    return found


def flat_mapping(mapping: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested mappings as values by dotted name; the later of two equal names wins."""
    found: dict[str, Any] = {}
    for name, value in mapping.items():
        path = joined(prefix, str(name))
        found |= flat_mapping(value, path) if isinstance(value, Mapping) else {path: value}
    return found


def hint(name: str, known: Iterable[str], *, cutoff: float = 0.5) -> str:
    """Return ``; did you mean ...?`` with the nearest known name, or last part; "" without."""
    plain = name.lower()

    def likeness(one: str) -> tuple[bool, float]:
        same = one.rpartition(".")[2] == plain
        return same, difflib.SequenceMatcher(None, one.lower(), plain).ratio()

    near = max(known, key=likeness, default="")
    return f"; did you mean {near}?" if near and max(likeness(near)) >= cutoff else ""


def timed(
    name: str, text: str, form: str, *, longest_s: float = math.inf, ordered: bool = True
) -> Iterator[tuple[str, float, list[str]]]:
    """Yield where each entry of a text ``TIME WORDS; TIME WORDS; ...`` stands, its time [s], its
    words; else ParameterError with the ``form`` that an entry must have, or the range of its time.
    """
    least_s = 0.0
    for number, part in enumerate(filter(str.strip, text.split(";")), start=1):
        where, (head, *words) = f"{name}: entry {number} {part.strip()!r}", part.split()
        try:
            time_s = float(head)
        except ValueError:
            time_s = math.nan
        if not words:
            raise ParameterError(f"{where}: must be {form}")
        if not least_s <= time_s <= longest_s or time_s == math.inf:
            raise ParameterError(
                f"{where}: time = {head}: must be {least_s:g}..{longest_s:g} s; entries come in "
                "the order of their times"
            )
        least_s = time_s if ordered else 0.0
        yield where, time_s, words
