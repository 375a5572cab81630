# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy of the channels of waves on every network: sessions of a minute with their defaults.

The least balance of every port of every session at every step of the server: of each way of the
channel and from hand to server. Each session is run by itself: its packets meet its own fates, and
hands differ in how far they carry.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmark import feel
from benchmark.fast import simulated
from benchmark.tasks import scenario_of
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.apart import apart
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_core.words import count, listed

TOGETHER = 5  # seeds of an item
END_S = 0.5


@dataclass(frozen=True)
class Plan:
    """The size of a sweep: channels with seeds per network, networks, and duration."""

    seeds: tuple[tuple[str, int], ...]
    networks: tuple[str, ...] = tuple(PRESETS)
    duration_s: float = 60.0

    @property
    def items(self) -> int:
        """Return how many groups of sessions are run."""
        return len(list(groups(self, 0)))

    @property
    def words(self) -> str:
        """Networks, duration and seeds, in words."""
        seeds = listed([f"{count(number, 'seed')} of {name}" for name, number in self.seeds])
        return f"{len(self.networks)} networks, {self.duration_s:g} s a session: {seeds} each"


FULL = Plan((("strict", 100), ("plain", 5)))  # the control shows itself with few
SHORT = Plan((("strict", 2), ("plain", 1)))


@dataclass(frozen=True)
class Group:
    """Sessions on one network, a seed each."""

    channel: str
    network: str
    seeds: tuple[int, ...]
    duration_s: float
    compiled: bool = True


@dataclass(frozen=True)
class Found:
    """Numbers of each session of a group: least balance, device less avatar in the last half
    second (the larger of both users), largest force and largest change of it within 1 ms.
    """

    least_j: list[float]
    apart_m: list[float]
    peak_n: list[float]
    step_n: list[float]


def groups(plan: Plan, seed: int) -> Iterator[Group]:
    """Yield the groups of a sweep, the first seeds of all networks first; ``seed`` is the first of
    every network.
    """
    for start in range(0, max(number for _, number in plan.seeds), TOGETHER):
        for network in plan.networks:
            for channel, number in plan.seeds:
                seeds = range(seed + start, seed + min(start + TOGETHER, number))
                if seeds:
                    yield Group(channel, network, tuple(seeds), plan.duration_s)


def found_in(group: Group) -> Found:
    """Run the sessions of a group."""
    settings = ("controller=pmwvc", f"channel={group.channel}")
    numbers = []
    for seed in group.seeds:
        scenario = scenario_of("carry", settings, group.network, seed, group.duration_s)
        traces = simulated(scenario, compiled=group.compiled)
        numbers.append(numbers_of(traces, scenario))
    return Found(*(list(column) for column in zip(*numbers, strict=True)))


def found_in_each(of: tuple[Group, ...]) -> list[Found]:
    """Run the sessions of some groups."""
    return [found_in(group) for group in of]


def numbers_of(traces: SessionTraces, scenario: Scenario) -> tuple[float, ...]:
    """Return least balance beyond the declared storage [J], distance at the end [m], largest force
    and step of it [N] of a session.
    """
    balances = [
        balance.minimum_j + balance.declared_j
        for user in user_energies(traces, scenario)
        for balance in user.parts.values()
    ]
    ends = [0.0]
    for user in traces.users:
        found = apart(traces, user)
        if found is not None:
            late = found.time_s >= traces.duration_s - END_S
            ends.append(float(np.linalg.norm(found.error[late].mean(axis=0))))
    step_n = feel.worst(traces, scenario).step_n
    return min(balances), max(ends), feel.peak_n(traces), step_n
