# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's part of the feed: blocks that wait for their row, and what is known at the newest
row.
"""

import math
from collections import deque

import numpy as np

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_end import kept_words, why_kept
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.feed.accounts import PageBalances
from pmwvc_view.feed.traces import (
    AVATAR,
    F_APPLIED,
    GONE_S,
    NS,
    SIGNALS,
    X_M,
    X_S,
    TraceBlock,
    TraceStep,
)
from pmwvc_view.protocol.snapshot import ENERGIES, Layout

LOADED_N = 0.1  # force from which a device counts as loaded
APART_M = 3e-3  # more than a press takes: so far from its avatar a device was when it joined
LAG = ("lag", "impedance")
NUMBERS = ("state", "missed", "delay_up", "delay_down", *ENERGIES)
UNKNOWN = (math.nan,) * 3


class FeedUser:
    """See above.

    Attributes
    ----------
    state, reason
        Of the newest tick in a row; state None: there was none, or none for ``GONE_S`` (then it
        is ``gone``).
    apart
        Whether its avatar is away from its device since it joined.
    lag_columns
        Names of columns whose values are given from elsewhere; ``lag_at``: the lag's place.
    loaded_change
        Whether tau/(2b) changed under load since the device was coupled.
    delays_s
        Mean delay of the newest packets, up and down [s].
    """

    def __init__(self, layout: Layout, name: str, scenario: Scenario | None) -> None:
        self.blocks: deque[TraceBlock] = deque()
        self._shown = 0  # ticks of the first of them
        self.loaded_change = False
        self.accounts = PageBalances()
        self.end_ns = -1
        self.state: int | None = None
        self.gone = False
        self.reason = ""
        self.lag_columns = tuple(f"{name}.{column}" for column in LAG)
        self.lag_at = layout.slices[f"{name}.lag"].start
        self.delays_s = [math.nan, math.nan]
        self._give = math.nan  # tau/(2b) by the model [m/N]
        self._why_apart = "it stays while nothing brings the avatar to the device"
        if scenario is not None:
            self._why_apart = why_kept(
                waves=has_waves(scenario.controller), black_box=scenario.coupling.black_box
            )
        self._there = self.apart = False
        self._distance_m = math.nan
        self._missed = math.nan
        self._signals: Array = np.full((len(SIGNALS), layout.dof), math.nan)  # newest tick
        self._signals_at = layout.together(name, SIGNALS)
        self._avatar_at = layout.together(name, AVATAR)
        self._least_at = layout.slices[f"{name}.f_min"]
        self._most_at = layout.slices[f"{name}.f_max"]
        self._late_at = layout.slices[f"{name}.lateness"].start
        self._numbers_at = layout.together(name, NUMBERS)
        self._server_at = layout.together(name, ("presence", "contact"))

    def write(self, row: Array, until_ns: int, step: TraceStep | None, index: int) -> None:
        """Write the ticks up to a time into a row in which nothing is known, and the avatar as of
        a step of the server (None before the first), in which the user has this number.
        """
        blocks, forces, late_s, block = self.blocks, [], -math.inf, None
        while blocks:
            first, ticks = self._shown, blocks[0].ticks
            end = min((until_ns - blocks[0].start_ns) // blocks[0].period_ns + 1, ticks)
            if end <= first:
                break
            block = blocks[0]
            forces.append(block.signals[F_APPLIED, first:end])
            late_s = max(late_s, *block.lateness_s[first:end])
            self._signals = block.signals[:, end - 1]
            if end < ticks:
                self._shown = end
                break
            self._shown = 0
            blocks.popleft()
        if block is not None:
            every = forces[0] if len(forces) == 1 else np.concatenate(forces)
            np.minimum.reduce(every, axis=0, out=row[self._least_at])
            np.maximum.reduce(every, axis=0, out=row[self._most_at])
            row[self._late_at] = late_s
            self.state, self._missed, self.reason = block.state, block.missed, block.reason
            self.gone = False
        elif self.state is not None and until_ns - self.end_ns > GONE_S * NS:
            self.state, self.reason, self.gone = None, "", True
            self._signals = np.full_like(self._signals, math.nan)
        row[self._signals_at] = self._signals.ravel()
        state = math.nan if self.state is None else self.state
        energies: list[float] = []
        for each in (self.accounts.up, self.accounts.down, self.accounts.hand):
            known = each.known and self.accounts.known_ns is not None
            energies += [each.in_j, each.out_j, each.least_j] if known else UNKNOWN
        row[self._numbers_at] = state, self._missed, *self.delays_s, *energies
        if step is not None and index < len(step.state):
            there = step.state[index] > 0
            self.apart = there and (not self._there or self.apart)  # it has just joined, or is yet
            if self.apart:
                self._distance_m = math.dist(step.avatars[X_S, index], self._signals[X_M])
                self.apart = self._distance_m > APART_M
            self._there = there
            row[self._avatar_at] = step.avatars[:, index].ravel()
            row[self._server_at] = step.state[index], step.contact[index]

    @property
    def channel_known(self) -> bool:
        """Whether the energy of both directions is known on its own."""
        return self.accounts.up.known and self.accounts.down.known

    @property
    def kept_apart(self) -> str:
        """How far the avatar is from the device since the user joined, and why; else nothing."""
        return kept_words(self._distance_m, self._why_apart) if self.apart else ""

    def follow_lag(self, lag_s: float | None, impedance: float | None) -> None:
        """Note lag [s] and impedance [N s/m] of a row, and whether they changed under load."""
        give = lag_s / (2.0 * impedance) if lag_s is not None and impedance else math.nan
        if self.state != SafetyState.COUPLED:
            self.loaded_change = False
        elif abs(give - self._give) > 1e-9 and np.linalg.norm(self._signals[F_APPLIED]) > LOADED_N:
            self.loaded_change = True
        self._give = give
