# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The criterion of passivity: the only one, for verdict, report, budget, summary and exit code.

A part with the balance E(t), energy in less energy out since the start, is passive with the
storage S that it declares when

    E(t) >= -S - C - tolerance(t)      at every instant judged.

``tolerance`` is what rounding explains. C is what counts of an encoder are bounded to make of the
work of a hand, 0.1 b q^2/h, at the port of that hand and its node only, on the strict channel
(:mod:`pmwvc_core.master.count_bound`). Verdicts print both, and the least balance.

What was not recorded is not judged: a balance seen below the limit is a violation whatever else is
missing; one that may have been there in a hole of the recording is neither passive nor not.

Equations: docs/theory.md 13.4.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmwvc_analysis.budget.parts import words_of
from pmwvc_analysis.traces.holes import Unjudged
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.traces.thresholds import TOLERANCE_J, TOLERANCE_RELATIVE
from pmwvc_core.master.count_bound import CountBound, count_bound
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import SessionTraces


@dataclass(frozen=True)
class Finding:
    """The judgement of one part: a port, a direction of the link, or a part of the budget."""

    owner: str  # a user, or ``server``
    part: str
    passive: bool | None  # None: not judged, ``why`` gives the reason
    least_j: float = 0.0  # lowest balance seen, never above the zero it starts from [J]
    least_s: float | None = None  # when [s]; None where the balance never went below zero
    since_s: float | None = None  # when it first was below the limit [s]
    tolerance_j: float = 0.0  # at that instant [J]
    declared_j: float = 0.0  # storage or allowance that is declared [J]
    moved_j: float = 0.0  # energy moved: the scale [J]
    unjudged: tuple[Unjudged, ...] = ()
    why: str = ""
    counts_j: float = 0.0  # what counts of an encoder are bounded to give out [J]
    held_j: float = 0.0  # of it, what forces held while a loop stood still explain [J]

    @property
    def words(self) -> str:
        """The part in words."""
        return words_of(self.part)

    @property
    def given_j(self) -> float:
        """Energy given out beyond what was taken in, at the worst [J]."""
        return -self.least_j


def tolerance(moved_j: Array) -> Array:
    """Return what rounding explains where so much energy was moved [J]."""
    return TOLERANCE_J + TOLERANCE_RELATIVE * np.abs(moved_j)


@dataclass(frozen=True)
class Balance:
    """One balance over time, and what the criterion allows it beside rounding."""

    time_s: Array  # (step,)
    energy_in_j: Array
    energy_out_j: Array
    declared_j: float = 0.0  # stored at the start
    counts_j: float = 0.0  # that counts of an encoder are bounded to make of it
    resolution_j: Array | float = 0.0  # (step,) how far it may be off, as an encoder has steps
    moved_j: float | None = None  # energy moved of which it is a part; None: its own

    @property
    def balance_j(self) -> Array:
        """Energy in less energy out [J]."""
        return self.energy_in_j - self.energy_out_j

    @property
    def tolerance_j(self) -> Array:
        """Largest deficit that counts as zero [J]."""
        scale_j = self.energy_in_j if self.moved_j is None else self.moved_j + 0.0 * self.time_s
        return tolerance(scale_j)

    @property
    def limit_j(self) -> Array:
        """The lowest balance that is passive, without what the encoder leaves open [J]."""
        return -self.tolerance_j - self.declared_j - self.counts_j

    @property
    def minimum_j(self) -> float:
        """The lowest balance, never above the zero it starts from [J]."""
        return min(0.0, float(self.balance_j.min(initial=0.0)))

    def judged(self, owner: str, part: str, unjudged: Sequence[Unjudged] = ()) -> Finding:
        """Return the result of the criterion; in ``unjudged`` the balance may have been below the
        limit. What an encoder cannot resolve, and what moved nothing, is not judged either.
        """
        balance_j, own_j = self.balance_j, np.abs([self.energy_in_j, self.energy_out_j])
        whys = [f"from {u.start_s:.2f} to {u.end_s:.2f} s {u.why}" for u in unjudged]
        whys[3:] = [f"{len(whys) - 3} more intervals"] if len(whys) > 3 else []
        moved_j = float(own_j.max(initial=0.0)) if self.moved_j is None else self.moved_j
        found = Finding(
            owner, part, None, tolerance_j=TOLERANCE_J, declared_j=self.declared_j,
            moved_j=moved_j, unjudged=tuple(unjudged), counts_j=self.counts_j,
            why="; ".join(whys) or "nothing of it was recorded",
        )  # fmt: skip
        if not len(balance_j):
            return found
        margin_j = balance_j + self.resolution_j - self.limit_j
        worst = int(np.argmin(margin_j))
        violated = np.flatnonzero(~(margin_j >= 0.0))  # what is not a number is no proof either
        least_j, seen = min(0.0, float(balance_j[worst])), len(violated) > 0
        why = found.why if unjudged and not seen else ""
        open_j = np.asarray(self.resolution_j)
        if not seen and not why and (margin_j - 2.0 * open_j < 0.0)[open_j > 0.0].any():
            most = f"by up to {1e3 * float(np.max(open_j)):.3g} mJ"
            why = f"the steps of the encoder leave the work of the hand open {most}"
        if not seen and not why and not own_j.any():
            why = "no energy was moved"
        return replace(
            found,
            passive=None if why else not seen,
            least_j=least_j,
            least_s=float(self.time_s[worst]) if least_j < 0.0 or seen else None,
            since_s=float(self.time_s[violated[0]]) if seen else None,
            tolerance_j=float((self.tolerance_j + open_j)[worst]),
            why=why,
        )


def together(verdicts: Iterable[bool | None]) -> bool | None:
    """Return the verdict of several: one violation decides; then what is not judged."""
    found = set(verdicts)
    return False if False in found else True if found == {True} else None


def behind_counts(user: User, scenario: Scenario) -> bool:
    """Tell whether a user's waves come of the differences of an encoder's counts."""
    return scenario.strict and user.device.differences and bool(user.device.encoder_step_m > 0.0)


def held(user: User) -> bool:
    """Tell whether a hand is on the device: a person's, or an arm that is simulated."""
    return not user.device.is_simulated or user.operator.has_arm


def bounded(user: User, scenario: Scenario) -> CountBound | None:
    """Return what a port behind counts is promised to give out at most; None where nothing is."""
    if not behind_counts(user, scenario) or not held(user):
        return None
    bound = count_bound(user.master, user.device)
    return bound if bound.holds else None


def counts_j(traces: SessionTraces, scenario: Scenario | None, name: str) -> float:
    """Return what a port behind counts may give out at most [J]; zero: no bound held."""
    found = [stage.scenario for stage in (stages(traces, scenario) if scenario else [])]
    bounds = [bounded(user, each) for each in found for user in each.users if user.name == name]
    return min((bound.given_j if bound else 0.0 for bound in bounds), default=0.0)


def passive_by_account(scenario: Scenario) -> bool:
    """Tell whether every port is passive by the strict channel's accounts, whatever the network
    does: the motion is exactly what the device reports, and no part gives out energy by its law.
    """
    exact = all(
        user.device.is_simulated
        and user.device.encoder_step_m <= 0.0
        and not user.master.bank.as_published
        for user in scenario.users
    )
    return exact and scenario.strict and scenario.coupling.passive(scenario.server)
