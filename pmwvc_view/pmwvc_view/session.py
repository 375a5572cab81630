# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session as the page's server sees it: one that goes on, live or simulated in real time. All of
it is called from one event loop.
"""

import asyncio
import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.names import why_fixed
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view import SNAPSHOT_S, controls, description
from pmwvc_view.controls import Control, Setting, Settings
from pmwvc_view.description import Predictor
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.tape import NS
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout, Snapshot

RATE = 0.5  # s of delay per s, where it changes in a running session


class Handled(NamedTuple):
    """The answer to a request: whether it was done, and why not, or what holds now."""

    done: bool
    text: str = ""


class Session(ABC):
    """A session for pages: its feed, the verdict on it, and notices.

    ``can`` names the kinds of requests that it serves, each by the method of its name (``take``,
    ``let_go`` and ``seen`` are the server's own), which takes the fields of the request and gives
    an ``Handled``; that of ``set`` and ``pause`` is awaited.
    """

    can = frozenset({"take", "let_go", "target", "set", "ask", "pause", "restart", "seen"})
    layout: Layout
    remote: Collection[str] = ()  # users whose handle a page can take
    wanted: Scenario  # to which settings are added
    preset: str | None = None  # the network by name
    paused = False  # whether time stands still
    _scenario: Scenario
    _duration_s: float | None = None  # None: it goes on until it is ended

    def __init__(self, *, live: bool) -> None:
        self.generation = 0  # counts its beginnings: another one, and all is described anew
        self.ended: str | None = None  # why it is over; None while it goes on
        self.report = ""  # where its report will be, "" where there will be none
        self._live, self._predictor = live, Predictor(live=live)
        self._changing = asyncio.Lock()

    def message(self, holders: Mapping[str, str | None]) -> dict[str, Any]:
        """Return the session message; ``holders``: who holds each user's handle."""
        return description.describe(
            self._scenario,
            self.layout,
            self._scene,
            mode="live" if self._live else "simulated",
            duration_s=self._duration_s,
            values=controls.values_of(self.wanted, self.preset),
            remote=self.remote,
            can=self.can,
            snapshot_s=SNAPSHOT_S,
            holders=holders,
        )

    @abstractmethod
    def poll(self) -> Sequence[Snapshot]:
        """Return the snapshots since the last call."""

    def target(self, user: str, position: tuple[float, ...] | None) -> None:
        """Give a hand that a page can take its newest target, within its workspace [m]; None, or
        another number of axes, opens it.
        """
        if user not in self.remote:
            return
        if position is not None and len(position) == self._scenario.dof:
            users = self._scenario.users
            reach = next(one.device.workspace_m for one in users if one.name == user)
            self._places[user] = [min(max(value, -reach), reach) for value in position]
        else:
            self._places[user] = None
        self._give(user, self._places[user])

    @abstractmethod
    def _give(self, user: str, position: Sequence[float] | None) -> None:
        """Give a hand its newest target [m]; None opens it."""

    @abstractmethod
    def _notes(self) -> list[str]:
        """Return notices as long as they hold."""

    @abstractmethod
    async def _change(self, control: Control, wanted: Scenario, value: Setting) -> str:
        """Change a parameter, to what is wanted then; return why not, or ""."""

    def _name_network(self, control: Control, value: Setting) -> None:
        """Note the network's name, which a change of a single setting of it takes away."""
        if control.path.startswith("link."):
            self.preset = str(value) if control.path == controls.PRESET else None

    async def ask(self, values: Settings) -> dict[str, Any] | None:
        """Return the exact model's prediction as its message; None where a newer question came."""
        return await self._predictor.ask(self.wanted, values)

    def close(self) -> None:
        """Let go of everything."""
        self._predictor.close()

    def _show(self, scenario: Scenario, exact: Sequence[str], scene: Mapping[str, Any]) -> None:
        """Begin to show a session; ``exact`` users have devices that count their true motion."""
        self._scenario = self.wanted = scenario
        self._exact, self._scene = exact, scene
        users, bodies = [user.name for user in scenario.users], description.moving(scene)
        self.layout = Layout(users, scenario.dof, bodies)
        self._feed = Feed(self.layout, scenario, period_ns=round(SNAPSHOT_S * NS), live=self._live)
        self._lags = description.lags(scenario, live=self._live)
        self._judge = Judge(self._feed.tape, scene)
        self._places: dict[str, Sequence[float] | None] = {}  # targets of hands; None: open [m]

    def _snapshots(
        self, now_ns: int, others: Mapping[str, Any] | None = None
    ) -> Sequence[Snapshot]:
        """Return the snapshots up to now [ns]; ``others``: more values by column."""
        places = {user: self._places.get(user) for user in self.remote}
        targets = {f"{user}.target": place for user, place in places.items()}
        held = {f"{user}.held": place is not None for user, place in places.items()}
        self._feed.others = {**self._lags, **(others or {}), **targets, **held}
        return self._feed.rows(now_ns)

    async def set(self, path: str, value: Setting) -> Handled:
        """Change a parameter; one change at a time."""
        try:
            control = controls.control_of(path)
            if control.path in controls.AT_RESTART:
                return Handled(False, f"{path}: changes with a new beginning (restart)")
            known = self.wanted
            server, coupling = known.server, known.coupling
            fixed = why_fixed(control.path, strict=known.strict, server=server, coupling=coupling)
            if fixed:
                return Handled(False, f"{control.path}: {fixed}")
            async with self._changing:
                wanted = controls.changed(self.wanted, {path: value})
                self._judge.changed()
                why = await self._change(control, wanted, value)
        except PmwvcError as error:
            return Handled(False, str(error))
        return Handled(not why, why or f"{path} = {value}")

    def news(self) -> Mapping[str, Mapping[str, Any]]:
        """Return verdict, values of controls, and whether time passes."""
        self._judge.judge(self._scenario)
        of = self._feed, self._judge, self._scenario
        text = verdict(*of, exact_hands=self._exact, notices=self._notes())
        return {
            "text": text,
            "values": {"values": controls.values_of(self.wanted, self.preset)},
            "play": {"paused": self.paused},
        }


def ramped(present: Scenario, wanted: Scenario, *, over_s: float) -> Scenario:
    """Return the scenario wanted, with delays as far from the present ones as may be after so
    long [s]; other settings of a link change once its delay is there. A delay that grows at once
    leaves a gap as long as its growth, beyond the watchdog's patience.
    """
    users = []
    for old, new in zip(present.users, wanted.users, strict=True):
        up = towards(old.link_up, new.link_up, over_s=over_s)
        down = towards(old.link_down, new.link_down, over_s=over_s)
        users.append(replace(new, link_up=up, link_down=down))
    return replace(wanted, users=tuple(users))


def towards(present: LinkParams, wanted: LinkParams, *, over_s: float) -> LinkParams:
    """Return the settings of one link after so long [s]."""
    most, step = RATE * over_s, wanted.delay_s - present.delay_s
    if abs(step) <= most:
        return wanted
    return replace(present, delay_s=present.delay_s + math.copysign(most, step))
