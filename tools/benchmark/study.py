# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The study: the same random search for every method on the training networks, over all tasks,
then sessions on all presets with seeds that the search has not met.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmark.fast import can_compile, pays
from benchmark.kept import Kept
from benchmark.methods import METHODS, Settings
from benchmark.tasks import TASKS
from benchmark.trial import Cost, Outcome, Trial, costed, run, usual
from benchmark.walls import WALL_S, Asked, Walls, wall, walls
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import count

TRAINING = ("thesis_lan_16", "wifi_campus", "lte", "lan", "continental")
FAR = ("geo", "iss", "lunar", "torture")  # beyond 0.3 s each way a wall takes longest
NEAR = tuple(name for name in PRESETS if name not in (*TRAINING[:4], *FAR))
HELD_OUT_SEED = 1000  # the first one of the sessions that judge
OURS, DEFAULTS = "strict", "strict, defaults"  # the second: what the search did to the first
INTERPRETED, INTERPRETED_SEEDS = 6, 2  # settings and seeds of a method that cannot be compiled
Kind = tuple[str, ...]
CHOOSING = ("controller=", "channel=")  # settings that choose laws,
SWITCHES = ("master.position.gain",)  # and numbers that switch some on
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
    walled
        Networks on which it is measured which walls are rendered.
    duration_s
        Of each session; None: that of its task.
    """

    candidates: int
    training: tuple[str, ...]
    training_seeds: int
    networks: tuple[str, ...]
    seeds: int
    walled: tuple[str, ...] = ()
    duration_s: float | None = None
    methods: tuple[str, ...] = tuple(METHODS)
    tasks: tuple[str, ...] = tuple(TASKS)

    def compiles(self, method: str) -> bool:
        """Tell whether the sessions of a method can be compiled."""
        default, (task, *_), (network, *_) = METHODS[method].settings, self.tasks, self.networks
        return can_compile(usual(method, default, task, network, 0).scenario)

    def tried(self, seed: int) -> dict[str, list[Settings]]:
        """Return the settings to try for each method."""
        fewer = min(INTERPRETED, self.candidates)
        return {
            name: METHODS[name].candidates(self.candidates if self.compiles(name) else fewer, seed)
            for name in self.methods
        }

    def seeds_of(self, method: str) -> int:
        """Return with how many seeds a method is judged."""
        return self.seeds if self.compiles(method) else min(INTERPRETED_SEEDS, self.seeds)

    def items(self, seed: int) -> int:
        """Return how many sessions and grids of walls are run."""
        tried = sum(map(len, self.tried(seed).values()))
        seeds = sum(map(self.seeds_of, self.methods)) + self.seeds * (OURS in self.methods)
        searched = tried * len(self.training) * self.training_seeds
        sessions = len(self.tasks) * (searched + len(self.networks) * seeds)
        return sessions + len(self.methods) * len(self.walled)

    @property
    def words(self) -> str:
        """Methods, settings and networks, in words."""
        methods, tasks = len(self.methods), len(self.tasks)
        searched = self.candidates * len(self.training) * self.training_seeds
        judged = len(self.networks) * self.seeds
        return (
            f"{methods} methods at {count(tasks, 'task')}, {self.candidates} settings of each on "
            f"{count(len(self.training), 'network')}, judged on {len(self.networks)}: "
            f"{methods * tasks * (searched + judged)} sessions, "
            f"{methods * len(self.walled)} grids of walls"
        )


FULL = Plan(60, TRAINING, 1, tuple(PRESETS), 6, walled=tuple(PRESETS))
MEDIUM = Plan(16, TRAINING[:4], 1, tuple(PRESETS), 2, walled=NEAR)
SHORT = Plan(4, TRAINING[:3], 1, tuple(PRESETS), 2)


@dataclass(frozen=True)
class Study:
    """The result of a study: the settings of each method, and what was measured with them."""

    plan: Plan
    seed: int
    tried: dict[str, int]
    chosen: dict[str, Settings]
    judged: Results
    walled: dict[Asked, Walls]

    @property
    def held_out(self) -> tuple[str, ...]:
        """Networks that no search has met."""
        return tuple(name for name in self.plan.networks if name not in self.plan.training)

    def of(self, method: str, task: str, networks: Sequence[str]) -> list[list[Outcome]]:
        """Return the outcomes of a method at a task, a list per network, by seed."""
        found: dict[str, list[tuple[int, Outcome]]] = {name: [] for name in networks}
        for trial, one in self.judged.items():
            if (trial.method, trial.task) == (method, task) and trial.network in found:
                found[trial.network].append((trial.seed, one))
        return [
            [one for _, one in sorted(row, key=lambda pair: pair[0])] for row in found.values()
        ]

    def rendered(self, method: str, networks: Sequence[str]) -> list[list[Walls]]:
        """Return the walls of a method likewise."""
        return [
            [
                one
                for asked, one in self.walled.items()
                if (asked.method, asked.network) == (method, name)
            ]
            for name in networks
        ]


@dataclass(frozen=True)
class Compiled:
    """The kinds of sessions that are compiled."""

    kinds: frozenset[Kind]

    def __contains__(self, item: Trial | Asked) -> bool:
        return kind_of(item) in self.kinds


def kind_of(item: Trial | Asked) -> Kind:
    """Return what decides on the laws of a session."""
    of = item.task if isinstance(item, Trial) else "walls"
    return (
        of,
        *(text for text in item.settings if text.startswith(CHOOSING)),
        *(name for name in SWITCHES if any(name in text for text in item.settings)),
    )


def compiled_of(trials: Sequence[Trial], asked: Sequence[Asked]) -> Compiled:
    """Return the kinds that take longer interpreted than compiling takes."""
    numbers, one_of = Counter[Kind](), dict[Kind, Scenario]()
    for trial in trials:
        numbers[kind_of(trial)] += 1
    for trial in _first(trials):
        one_of[kind_of(trial)] = trial.scenario
    for each in asked:
        numbers[kind_of(each)] += len(each.grid.stiffnesses_n_m) * len(each.grid.dampings_n_s_m)
        one_of[kind_of(each)] = wall(each.settings, each.network, each.seed, WALL_S)
    return Compiled(frozenset(kind for kind, k in numbers.items() if pays(k, one_of[kind])))


def _first(trials: Iterable[Trial]) -> list[Trial]:
    return list({kind_of(trial): trial for trial in trials}.values())


def study(plan: Plan, seed: int, kept: Kept) -> Study:
    """Tune and judge every method.

    Parameters
    ----------
    plan, seed
        What is run; the same give the same results.
    kept
        What is finished already, and what computes the rest.
    """
    tried = plan.tried(seed)
    searched = _trials(plan, tried, plan.training, range(seed, seed + plan.training_seeds))
    first = seed + HELD_OUT_SEED
    likely = {name: [each[-1]] for name, each in tried.items()}
    seeds = range(first, first + plan.seeds)
    compiled = compiled_of(
        [*searched, *_trials(plan, likely, plan.networks, seeds)], _walls(plan, likely, first)
    )
    # Each once, before several processes would compile the same.
    kinds = _first(trial for trial in searched if trial in compiled)
    kept.prepare(
        partial(_costed, compiled=compiled), [replace(one, duration_s=0.1) for one in kinds]
    )
    of_search = partial(_costed, compiled=compiled)
    training = kept.results(of_search, searched, Cost, together=_place)
    chosen = {name: _best(name, tried[name], training) for name in plan.methods}
    settings = {name: [each] for name, each in chosen.items()}
    judging = [
        trial
        for name, each in settings.items()
        for trial in _trials(plan, {name: each}, plan.networks, seeds[: plan.seeds_of(name)])
    ]
    if OURS in plan.methods:
        of_defaults = {DEFAULTS: [METHODS[OURS].settings]}
        judging += _trials(plan, of_defaults, plan.networks, seeds)
    judged = kept.results(partial(_run, compiled=compiled), judging, Outcome, together=_place)
    asked = _walls(plan, settings, first)
    found = kept.results(partial(_rendered, compiled=compiled), asked, Walls)
    numbers = {name: len(each) for name, each in tried.items()}
    return Study(plan, seed, numbers, chosen, judged, found)


def _trials(
    plan: Plan, settings: dict[str, list[Settings]], networks: tuple[str, ...], seeds: range
) -> list[Trial]:
    return [
        Trial(name, each, task, network, seed, plan.duration_s or TASKS[task].duration_s)
        for task in plan.tasks
        for network in networks
        for seed in seeds
        for name in settings
        for each in settings[name]
    ]


def _walls(plan: Plan, settings: dict[str, list[Settings]], seed: int) -> list[Asked]:
    return [
        Asked(name, each, network, seed)
        for network in plan.walled
        for name in settings
        for each in settings[name]
    ]


def _place(trial: Trial) -> tuple[object, ...]:
    """Return what sessions share that meet the same packets: worked out once for them."""
    return trial.task, trial.network, trial.seed


def _costed(trials: tuple[Trial, ...], *, compiled: Compiled) -> list[Cost]:
    return [costed(trial, compiled=trial in compiled) for trial in trials]


def _run(trials: tuple[Trial, ...], *, compiled: Compiled) -> list[Outcome]:
    return [run(trial, compiled=trial in compiled) for trial in trials]


def _rendered(asked: tuple[Asked, ...], *, compiled: Compiled) -> list[Walls]:
    return [walls(each, compiled=each in compiled) for each in asked]


def _best(method: str, candidates: list[Settings], results: dict[Trial, Cost]) -> Settings:
    """Return the settings with the least mean cost over all tasks; of equal ones the first."""
    costs: dict[Settings, list[float]] = {settings: [] for settings in candidates}
    for trial, found in results.items():
        if trial.method == method:
            costs[trial.settings].append(found.cost)
    return candidates[int(np.argmin([np.mean(costs[each]) for each in candidates]))]
