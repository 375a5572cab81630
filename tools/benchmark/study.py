# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The study: the same random search for every method on the training networks, then sessions on
all presets with seeds that the search has not met.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmark.kept import Kept
from benchmark.methods import METHODS, Settings
from benchmark.probe import Probe, Rendered, rendered
from benchmark.trial import Outcome, Trial, run
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.words import count

TRAINING = ("thesis_lan_16", "wifi_campus", "lte", "lan", "continental")
FAR = ("geo", "iss", "lunar", "torture")  # beyond 0.3 s each way probes take longest
NEAR = tuple(name for name in PRESETS if name not in (*TRAINING[:4], *FAR))
HELD_OUT_SEED = 1000  # the first one of the sessions that judge
Results = dict[Trial, Outcome]


@dataclass(frozen=True)
class Plan:
    """The size of a study.

    Attributes
    ----------
    candidates
        Settings tried for each method, the defaults among them.
    training, training_seeds
        Networks and seeds per network of the search.
    networks, seeds
        The same of the sessions that judge.
    duration_s
        Of each session.
    probing, probes, hold_s
        Networks of the sessions that measure what is rendered, seeds of each, duration of a hold.
    """

    candidates: int
    training: tuple[str, ...]
    training_seeds: int
    networks: tuple[str, ...]
    seeds: int
    duration_s: float = 10.0
    probing: tuple[str, ...] = ()
    probes: int = 1
    hold_s: float = 60.0
    methods: tuple[str, ...] = tuple(METHODS)

    @property
    def sessions(self) -> int:
        """Return how many sessions of each method are run."""
        training = self.candidates * len(self.training) * self.training_seeds
        return training + len(self.networks) * self.seeds

    @property
    def probed(self) -> int:
        """Return how many probes of each method are run."""
        return len(self.probing) * self.probes

    @property
    def items(self) -> int:
        """Return how many sessions and probes are run."""
        return len(self.methods) * (self.sessions + self.probed)

    @property
    def words(self) -> str:
        """Methods, settings and networks, in words."""
        methods = len(self.methods)
        return (
            f"{methods} methods, {self.candidates} settings of each on "
            f"{count(len(self.training), 'network')}, judged on {len(self.networks)}: "
            f"{methods * self.sessions} sessions of {self.duration_s:g} s, "
            f"{count(methods * self.probed, 'probe')}"
        )


FULL = Plan(60, TRAINING, 2, tuple(PRESETS), 10, probing=tuple(PRESETS), probes=3)
MEDIUM = Plan(12, TRAINING[:4], 1, tuple(PRESETS), 4, probing=NEAR, hold_s=20.0)
SHORT = Plan(6, TRAINING[:3], 1, tuple(PRESETS), 3, probing=NEAR, hold_s=10.0)


@dataclass(frozen=True)
class Study:
    """The result of a study: the settings of each method, the sessions that judge them, and the
    probes' results.
    """

    plan: Plan
    seed: int
    chosen: dict[str, Settings]
    judged: Results
    probed: dict[Probe, Rendered]

    @property
    def held_out(self) -> tuple[str, ...]:
        """Networks that no search has met."""
        return tuple(name for name in self.plan.networks if name not in self.plan.training)

    @property
    def probed_on(self) -> tuple[str, ...]:
        """Those of them on which it was measured what is rendered."""
        return tuple(name for name in self.held_out if name in self.plan.probing)

    def of(self, method: str, networks: Sequence[str]) -> list[list[Outcome]]:
        """Return the outcomes of a method, a list per network, by seed."""
        return [
            [
                self.judged[trial]
                for trial in sorted(self.judged, key=lambda trial: trial.seed)
                if (trial.method, trial.network) == (method, name)
            ]
            for name in networks
        ]

    def measured(self, method: str, networks: Sequence[str]) -> list[list[Rendered]]:
        """Return what was rendered by a method, a list per network, by seed."""
        found = sorted(self.probed.items(), key=lambda pair: pair[0].seed)
        return [
            [one for probe, one in found if (probe.method, probe.network) == (method, name)]
            for name in networks
        ]


def study(plan: Plan, seed: int, kept: Kept) -> Study:
    """Tune and judge every method.

    Parameters
    ----------
    plan, seed
        What is run; the same give the same results.
    kept
        What is finished already, and what computes the rest.
    """

    def trials(
        settings: dict[str, list[Settings]], networks: tuple[str, ...], first: int, seeds: int
    ) -> list[Trial]:
        return [
            Trial(name, each, network, first + number, plan.duration_s)
            for network in networks
            for number in range(seeds)
            for name in plan.methods
            for each in settings[name]
        ]

    tried = {name: METHODS[name].candidates(plan.candidates, seed) for name in plan.methods}
    searched = trials(tried, plan.training, seed, plan.training_seeds)
    training = kept.results(run, searched, Outcome)
    chosen = {name: _best(name, tried[name], training) for name in plan.methods}
    judging = trials(
        {name: [settings] for name, settings in chosen.items()},
        plan.networks,
        seed + HELD_OUT_SEED,
        plan.seeds,
    )
    probes = [
        Probe(name, chosen[name], network, seed + HELD_OUT_SEED + number, plan.hold_s)
        for network in plan.probing
        for number in range(plan.probes)
        for name in plan.methods
    ]
    judged = kept.results(run, judging, Outcome)
    return Study(plan, seed, chosen, judged, kept.results(rendered, probes, Rendered))


def _best(method: str, candidates: list[Settings], results: Results) -> Settings:
    """Return the settings with the least mean cost; of equal ones the first."""
    costs = [
        np.mean(
            [
                outcome.cost
                for trial, outcome in results.items()
                if trial.method == method and trial.settings == settings
            ]
        )
        for settings in candidates
    ]
    return candidates[int(np.argmin(costs))]
