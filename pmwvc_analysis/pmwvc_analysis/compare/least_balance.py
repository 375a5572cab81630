# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lowest energy balance of a session, over every port that decides its passivity.

The links alone do not decide: a server that decodes a step late, or a compensation that stretches
a wave, generates energy behind a passive link.
"""

from typing import NamedTuple

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.passivity_words import part_words
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


class Least(NamedTuple):
    """Lowest balance [J], of which port, and whether all are passive; None: unknown."""

    energy_j: float | None
    part: str | None
    passive: bool | None


def least_balance(traces: SessionTraces, scenario: Scenario | None) -> Least:
    """Return the lowest balance of a session and its verdict."""
    found = passivity(traces, scenario, budget(traces, scenario))
    ports = [finding for finding in found.findings if finding.decides and finding.judged_s]
    if not ports:
        return Least(None, None, None)
    worst = min(ports, key=lambda finding: finding.least_j)
    owner = "" if worst.part == SERVER else f"{worst.owner}: "
    part = f"{owner}{part_words(worst)}" if worst.least_j < 0.0 else None
    return Least(worst.least_j, part, found.session)
