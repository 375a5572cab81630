# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Families of laws: one name for laws of which the type of the state (or of the parameters, where
there is no state) says which is meant.

A law joins with ``@family.member(State)``; a plug-in does the same. A call looks the type of its
first argument up; compiled, it is known beforehand and costs nothing.
"""

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


class Family:
    """Laws chosen by the type of their first argument.

    Attributes
    ----------
    name
        In messages.
    members
        Law by that type.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.members: dict[type, Callable[..., Any]] = {}

    def member(self, kind: type) -> Callable[[F], F]:
        """Return the decorator that makes a function the law for a type."""

        def join(law: F) -> F:
            self.members[kind] = law
            return law

        return join

    def __call__(self, first: Any, *others: Any) -> Any:
        """Call the law for the type of the first argument."""
        return self.members[type(first)](first, *others)
