# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's part of the feed: blocks that wait for their row, and what is known at the newest
row.
"""

import math
from collections import deque
from typing import Any

import numpy as np

from pmwvc_core.controllers import has_waves
from pmwvc_core.master.safety.states import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.kept_apart import kept_words, why_kept
from pmwvc_view.feed.accounts import Accounts
from pmwvc_view.feed.shaking import Shaking
from pmwvc_view.feed.traces import AVATAR, F_APPLIED, F_H, SIGNALS, X_M, X_S, XD_M, Block, Step
from pmwvc_view.protocol.snapshot import ENERGIES, Layout

LOADED_N = 0.1  # force from which a device counts as loaded
APART_M = 3e-3  # more than a press takes: so far from its avatar a device was when it joined
MOVED_M = 5e-4  # by which a target moves on purpose
OPEN_N = 1e-6  # force of an open hand beyond its brake's
LAG = ("lag", "impedance")


class FeedUser:
    """See above.

    Parameters
    ----------
    brake
        Of its hand where it is open [N s/m]; None where its targets do not come from outside.

    Attributes
    ----------
    state, reason, waves
        Of the newest tick in a row; state None: there was none.
    loaded_change
        Whether tau/(2b) changed under load since the device was coupled.
    delays_s
        Mean delay of the newest packets, up and down [s].
    """

    def __init__(
        self, layout: Layout, name: str, shaking: Shaking, brake: float | None, why_apart: str = ""
    ) -> None:
        self.blocks: deque[Block] = deque()
        self.shaking = shaking
        self.in_contact = False
        self.loaded_change = False
        self.accounts = Accounts()
        self.end_ns = -1
        self.state: int | None = None
        self.reason = ""
        self.waves = False
        self.delays_s = [math.nan, math.nan]
        self._give = math.nan  # tau/(2b) by the model [m/N]
        self._brake = brake
        self._why_apart = why_apart
        self._there = self._apart = False  # at the server; away from the device since it joined
        self._distance_m = math.nan
        self._anchor: Array | None = None  # where the target was when it moved last
        self._missed = math.nan
        self._signals: Array = np.full((len(SIGNALS), layout.dof), math.nan)  # newest tick
        self._signals_at = layout.together(name, SIGNALS)
        self._avatar_at = layout.together(name, AVATAR)
        self._extremes_at = layout.together(name, ("f_min", "f_max"))
        self._late_at = layout.slices[f"{name}.lateness"].start
        self._numbers_at = layout.together(
            name, ("state", "missed", "delay_up", "delay_down", *ENERGIES)
        )
        self._server_at = layout.together(name, ("presence", "contact"))

    def write(self, row: Array, until_ns: int, step: Step | None, index: int) -> None:
        """Write the ticks up to a time into a row in which nothing is known, and the avatar as of
        a step of the server (None before the first), in which the user has this number.
        """
        forces, late = [], []
        while self.blocks and self.blocks[0].start_ns <= until_ns:
            block = self.blocks[0]
            count = min((until_ns - block.start_ns) // block.period_ns + 1, block.ticks)
            forces.append(block.signals[F_APPLIED, :count])
            late.append(max(block.lateness_s[:count]))
            self._signals = block.signals[:, count - 1]
            self.state, self._missed = block.state, block.missed
            self.waves, self.reason = block.waves, block.reason
            if count < block.ticks:
                self.blocks[0] = block.rest(count)
                break
            self.blocks.popleft()
        if forces:
            every = np.concatenate(forces)
            row[self._extremes_at] = *every.min(axis=0), *every.max(axis=0)
            row[self._late_at] = max(late)
        row[self._signals_at] = self._signals.ravel()
        state = math.nan if self.state is None else self.state
        row[self._numbers_at] = state, self._missed, *self.delays_s, *self._energies()
        if step is not None and index < len(step.state):
            self._follow_avatar(step, index)
            row[self._avatar_at] = step.avatars[:, index].ravel()
            row[self._server_at] = step.state[index], step.contact[index]

    @property
    def kept_apart(self) -> str:
        """How far the avatar is from the device since the user joined, and why; else nothing."""
        return kept_words(self._distance_m, self._why_apart) if self._apart else ""

    def _follow_avatar(self, step: Step, index: int) -> None:
        """Note how far the avatar is from the device, and whether it has been since joining."""
        there = step.state[index] > 0
        apart = step.avatars[X_S, index] - self._signals[X_M]
        self._distance_m = float(np.linalg.norm(apart))
        joined = there and not self._there
        self._apart = there and (joined or self._apart) and self._distance_m > APART_M
        self._there = there

    def aims(self, target: Any) -> bool:
        """Tell whether the hand moves on purpose, given the target of a row [m]; None: no page
        holds it.
        """
        if self._brake is None:
            return False
        anchor = self._anchor
        if target is None:
            self._anchor = None
            own = self._signals[F_H] + self._brake * self._signals[XD_M]
            held = bool(np.abs(own).max() > OPEN_N)  # by another program
            return held or anchor is not None
        position = np.atleast_1d(np.asarray(target, dtype=np.float64))
        if anchor is not None and np.linalg.norm(position - anchor) < MOVED_M:
            return False
        self._anchor = position
        return True

    def follow_lag(self, lag_s: float | None, impedance: float | None) -> None:
        """Note lag [s] and impedance [N s/m] of a row, and whether they changed under load."""
        give = lag_s / (2.0 * impedance) if lag_s is not None and impedance else math.nan
        if self.state != SafetyState.COUPLED:
            self.loaded_change = False
        elif abs(give - self._give) > 1e-9 and np.linalg.norm(self._signals[F_APPLIED]) > LOADED_N:
            self.loaded_change = True
        self._give = give

    def _energies(self) -> list[float]:
        """Return the accounts in the order of their columns; not known before the first balance,
        nor either direction where there are no waves.
        """
        accounts = self.accounts
        if accounts.known_ns is None:
            return [math.nan] * len(ENERGIES)
        up, down, hand = accounts.up, accounts.down, accounts.hand
        ways = [up.in_j, up.out_j, up.least_j, down.in_j, down.out_j, down.least_j]
        if not self.waves:
            ways = [math.nan] * len(ways)
        return [*ways, hand.in_j, hand.out_j, hand.least_j]


def brake_of(scenario: Scenario | None, name: str) -> float | None:
    """Return what brakes a user's open hand; None where its targets do not come from outside."""
    for user in scenario.users if scenario else ():
        if user.name == name and user.operator.kind == "remote" and not user.operator.file:
            return user.operator.remote.brake
    return None


def why_apart(scenario: Scenario | None) -> str:
    """Return why a distance between avatar and device stays after joining."""
    if scenario is None:
        return "it stays while nothing brings the avatar to the device"
    return why_kept(waves=has_waves(scenario.controller), black_box=scenario.coupling.black_box)
