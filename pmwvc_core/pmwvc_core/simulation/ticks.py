# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ticks of one user's loop in virtual time: when each is due, and what those that ran gave."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from pmwvc_core.numeric import Value


class Frame(NamedTuple):
    """Ticks of a frame that ran, all or a part.

    Attributes
    ----------
    ticks, times_ns
        Of the session, and when they ran [ns].
    values
        Signals tick by tick, in the order of ``SIGNALS``.
    ends
        Tick with which the next frame starts; None while more of this one is to run.
    """

    ticks: Sequence[int]
    times_ns: Sequence[int]
    values: list[Value]
    ends: int | None


class Ticks:
    """The ticks of a loop, counted by the session.

    Parameters
    ----------
    first
        Tick of the session at which the loop counts 0.
    begin
        First tick that runs.
    at_ns
        Time of every tick of the session up to the last that runs.
    missed
        Ticks in between that do not run: they pass when the loop runs again.

    Attributes
    ----------
    next
        The next tick that runs or passes.
    """

    def __init__(
        self, first: int, begin: int, at_ns: Sequence[int], missed: frozenset[int] = frozenset()
    ) -> None:
        self.first, self.next, self.at_ns = first, begin, at_ns
        self._missed, self._ran = missed, begin - 1  # the last tick that ran

    def are_due(self, until_ns: int) -> bool:
        """Tell whether a tick is due by an instant [ns]."""
        return self.next < len(self.at_ns) and self.at_ns[self.next] <= until_ns

    def passing(self, most: int) -> Iterator[int]:
        """Pass what was missed; yield the ticks before ``most`` after the last one that ran."""
        while self.next in self._missed:
            if self.next < self._ran + most:
                yield self.next
            self.next += 1

    def take(self, before_ns: int, ends: int) -> tuple[range, bool]:
        """Take the ticks before an instant [ns] of a frame that ends with tick ``ends``; return
        them, and whether they are the last of it.
        """
        begin, ends = self.next, min(ends, len(self.at_ns))
        after = bisect_left(self.at_ns, before_ns, begin, ends)
        if self._missed:
            after = next((k for k in range(begin, after) if k in self._missed), after)
        self._ran, following = after - 1, after
        while following in self._missed:
            following += 1
        self.next = after
        return range(begin, after), following >= ends
