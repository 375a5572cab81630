# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Families of laws: one name for laws of which the type of the state (or of the parameters, where
there is no state) says which is meant; compiled, it is known beforehand and costs nothing. A law
joins with ``@family.member(State)``; a plug-in does the same.
"""

from collections import defaultdict
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


class Nothing(NamedTuple):
    """State and parameters where there is nothing: no filter, no position feedback."""

    none: int


NOTHING = Nothing(0)


def same(s: Any, *others: Any) -> Any:
    """Return the state as it is."""
    return s


def passed(s: Any, signal: Any, *others: Any) -> Any:
    """Return state and signal as they are."""
    return s, signal


def no_accounts(first: Any, *others: Any) -> Any:
    """Return no energies."""
    return ()


def never(first: Any, *others: Any) -> bool:
    """Tell that it is not so."""
    return False


class Family:
    """Laws by the type of the first argument, or a default; KeyError where there is neither."""

    def __init__(self, name: str, default: Callable[..., Any] | None = None) -> None:
        self.name = name
        self.members = defaultdict[type, Callable[..., Any]](default and (lambda: default))

    def member(self, *kinds: type) -> Callable[[F], F]:
        """Return the decorator that makes a function the law for types."""

        def join(law: F) -> F:
            self.members.update(dict.fromkeys(kinds, law))
            return law

        return join

    def __call__(self, first: Any, *others: Any) -> Any:
        """Call the law for the type of the first argument."""
        return self.members[type(first)](first, *others)


accounts = Family("accounts", no_accounts)  # (s, p) -> sums and levels of a part [J]
opened = Family("opened", same)  # (s) -> s at its start, its lists made here: for compiled laws
