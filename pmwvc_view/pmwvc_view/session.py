# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session as the page's server sees it: live, simulated in real time, or recorded."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.controls import Setting, Settings
from pmwvc_view.prediction import Predictor
from pmwvc_view.protocol.snapshot import Layout, Snapshot


class Answer(NamedTuple):
    """The answer to a request: whether it was done, and why not, or what holds now."""

    done: bool
    text: str = ""


BEGIN_ANEW = "changes with a new beginning (restart)"
REFUSED = Answer(False, "not in this session")


class Session(ABC):
    """The interface between a page and its session; all of it is called from one event loop.

    A kind of session names in ``can`` the requests that it serves, and leaves the others as here.

    Attributes
    ----------
    can
        Kinds of requests that it serves.
    generation
        Counts its beginnings: another number, and everything is described anew.
    ended
        Why it is over; None while it goes on.
    back
        Whether the same address will serve again once it is over.
    report
        Where its report will be, "" where there will be none.
    """

    can: frozenset[str] = frozenset()
    layout: Layout

    def __init__(self, predictor: Predictor) -> None:
        self._predictor = predictor
        self.generation = 0
        self.ended: str | None = None
        self.back = False
        self.report = ""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """Return the session message without what the server adds."""

    @abstractmethod
    def scenario(self) -> Scenario:
        """Return the scenario that settings are added to."""

    @abstractmethod
    def poll(self) -> Sequence[Snapshot]:
        """Return the snapshots since the last call."""

    @abstractmethod
    def news(self) -> Mapping[str, Mapping[str, Any]]:
        """Return the messages whose content changes now and then, by kind: text, values, play."""

    def target(self, user: str, position: tuple[float, ...] | None) -> Answer:
        """Give a hand its newest target [m]; None opens it."""
        return REFUSED

    async def set(self, path: str, value: Setting) -> Answer:
        """Change a parameter."""
        return REFUSED

    def expect_questions(self) -> None:
        """Make ready for questions, which come once a page has been shown for a while."""
        self._predictor.begin()

    async def ask(self, values: Settings) -> dict[str, Any] | None:
        """Return the exact model's prediction with these settings, as its message; None where a
        newer question came.
        """
        return await self._predictor.ask(self.scenario(), values)

    async def pause(self, paused: bool) -> Answer:
        """Let time stand still, or go on."""
        return REFUSED

    def restart(self, values: Settings) -> Answer:
        """Begin again with these settings."""
        return REFUSED

    def seek(self, time_s: float) -> Answer:
        """Go to another time."""
        return REFUSED

    def speed(self, ratio: float) -> Answer:
        """Let time pass at this ratio."""
        return REFUSED

    def close(self) -> None:
        """Let go of everything."""
        self._predictor.close()
