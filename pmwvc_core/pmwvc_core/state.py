# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The explicit state of a block: a value that can be read, set and kept.

A block names the attributes that change while it runs, in three texts::

    BLOCKS   blocks inside it, or lists of them; None where there is none
    SIGNALS  what its linear law carries from tick to tick, ``(..., dof)``
    MEMORY   everything else: sums, counters, flags, packets

The state of a block is one mapping with those of the blocks inside it under dotted names (leading
underscores left out): ``hold.value``, ``ports.0.contact.deflection``. So a snapshot of a whole end
is that of its outermost block. Parameters are no state: a snapshot fits a block with the same
ones. No tick calls any of this.
"""

import copy
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeAlias

from pmwvc_core.numeric import Value

State: TypeAlias = Mapping[str, Any]


class Stateful:
    """A block with state; see the module. What a base class declares is part of it."""

    __slots__ = ()
    BLOCKS: ClassVar[str] = ""
    SIGNALS: ClassVar[str] = ""
    MEMORY: ClassVar[str] = ""

    def snapshot(self) -> State:
        """Return the state; nothing that happens later changes it."""
        return {
            name: copy.deepcopy(getattr(owner, attribute))
            for name, owner, attribute in attributes(self)
        }

    def restore(self, state: State) -> None:
        """Set the state; the mapping can be used again.

        Raises
        ------
        ValueError
            If it is the state of another kind of block.
        """
        declared = list(attributes(self))
        other = state.keys() ^ {name for name, _, _ in declared}
        if other:
            raise ValueError(
                f"{type(self).__name__}: the state of another block; in one of both only: "
                f"{', '.join(sorted(other))}"
            )
        for name, owner, attribute in declared:
            setattr(owner, attribute, copy.deepcopy(state[name]))

    def signals(self) -> dict[str, Value]:
        """Return the signals alone; those kept in tuples and mappings as ``read.0``."""
        found: dict[str, Value] = {}
        for name, owner, attribute in attributes(self, "SIGNALS"):
            found.update(_leaves(name, getattr(owner, attribute)))
        return found

    def set_signals(self, values: Mapping[str, Value]) -> None:
        """Set signals by their names; the others stay."""
        for name, owner, attribute in attributes(self, "SIGNALS"):
            setattr(owner, attribute, _with(name, getattr(owner, attribute), values))


def attributes(block: Stateful, *kinds: str) -> Iterator[tuple[str, Any, str]]:
    """Yield what a block and those inside it declare: name, owner and attribute.

    Parameters
    ----------
    kinds
        ``SIGNALS`` or ``MEMORY``; both by default. Code from elsewhere that stands where a block
        may (a plug-in) is memory as a whole.
    """
    wanted = kinds or ("SIGNALS", "MEMORY")
    for kind in wanted:
        for attribute in _declared(block, kind):
            yield _key(attribute), block, attribute
    for attribute in _declared(block, "BLOCKS"):
        inside = getattr(block, attribute)
        for name, each in _named(_key(attribute), inside):
            if isinstance(each, Stateful):
                for inner, owner, own in attributes(each, *wanted):
                    yield f"{name}.{inner}", owner, own
            elif each is not None and "MEMORY" in wanted:
                yield name, block, attribute


def _declared(block: Stateful, kind: str) -> list[str]:
    return [
        name for base in type(block).__mro__[::-1] for name in vars(base).get(kind, "").split()
    ]


def _key(attribute: str) -> str:
    return attribute.lstrip("_")


def _named(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the elements of a list, tuple or mapping with their names, or else the value."""
    if isinstance(value, dict):
        yield from ((f"{name}.{key}", each) for key, each in value.items())
    elif isinstance(value, (list, tuple)):
        yield from ((f"{name}.{index}", each) for index, each in enumerate(value))
    else:
        yield name, value


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Value]]:
    if isinstance(value, (dict, list, tuple)):
        for inner, each in _named(name, value):
            yield from _leaves(inner, each)
    else:
        yield name, value


def _with(name: str, value: Any, values: Mapping[str, Value]) -> Any:
    """Return a value with the leaves that are named."""
    if isinstance(value, dict):
        return {key: _with(f"{name}.{key}", each, values) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_with(inner, each, values) for inner, each in _named(name, value))
    return values.get(name, value)
