# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy balances of a session while it runs, as the report forms them, and the worst so far.

They are formed over the newest second, again and again; the nodes' counters are sums since their
start. Once a node is started again, or a user comes back, what was on its way then is in one
counter only: the balances are no longer judged.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.criterion import Balance, server_allowance_j
from pmwvc_analysis.budget.energy import UserEnergy, server_sums
from pmwvc_analysis.traces.thresholds import TOLERANCE_J
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces

WAYS = {"up": "way up", "down": "way down", "hand_port": "hand to object"}


class Worst(NamedTuple):
    """The balance nearest to its limit, or farthest below; the limit is that of its own time."""

    margin_j: float = TOLERANCE_J  # balance above its limit
    balance_j: float = 0.0
    time_s: float = 0.0

    def or_lower(self, balance: Balance) -> "Worst":
        """Return the worst of this and of a balance."""
        margin = balance.balance_j - balance.limit_j
        row = int(margin.argmin())  # not a number: never below
        found = Worst(*(float(each[row]) for each in (margin, balance.balance_j, balance.time_s)))
        return found if found.margin_j < self.margin_j else self


class Balances:
    """The balances of one user. ``energy`` is the newest, None where none is known; ``judged``:
    both counters are in their first life; ``worst`` and ``least_j`` [J] are those of each part.
    """

    def __init__(self) -> None:
        self.energy: UserEnergy | None = None
        self.judged = True
        self.worst: dict[str, Worst] = {}
        self.least_j: dict[str, float] = {}

    @property
    def known(self) -> bool:
        """Whether there is a balance."""
        return self.energy is not None and bool(np.isfinite(self.energy.joint.balance_j).all())

    @property
    def channel_known(self) -> bool:
        """Whether the energy of both directions is known on its own."""
        return self.known and self.energy is not None and len(self.energy.parts) == len(WAYS)

    def begin_anew(self) -> None:
        """Note that a counter began anew."""
        self.energy, self.judged = None, False

    def update(self, energy: UserEnergy) -> None:
        """Take in the balances of the newest second."""
        if not self.judged or not len(energy.joint.time_s):
            return
        begun = [each.balance_j[0] < each.limit_j[0] for each in energy.parts.values()]
        if self.energy is None and any(begun):  # of counters that began at different times
            self.judged = False
            return
        self.energy = energy
        for part, balance in energy.parts.items():
            self.worst[part] = self.worst.get(part, Worst()).or_lower(balance)
            self.least_j[part] = min(self.least_j.get(part, 0.0), balance.minimum_j)


class ServerBalance:
    """What the server took in at all ports less what it gave, until a counter begins anew."""

    def __init__(self) -> None:
        self.worst, self.judged = Worst(), True

    def update(self, server: ServerTraces, scenario: Scenario) -> None:
        """Take in the steps of the newest second."""
        if self.judged and not scenario.environment.own_energy(scenario.server):
            took, gave, _ = server_sums(server)
            allowed_j = server_allowance_j(scenario)
            self.worst = self.worst.or_lower(Balance(server.time_s, took, gave, allowed_j))
