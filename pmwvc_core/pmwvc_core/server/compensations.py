# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compensations of the energy of late decoding by name (App. C section 5): the library, and entry
points of the group ``pmwvc.compensations``. Their laws are in
:mod:`pmwvc_core.law.black_box.compensations`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pmwvc_core.account import Entry, Role
from pmwvc_core.law.black_box.compensations import AsPublished, Corrected, JointLedger
from pmwvc_core.law.family import NOTHING
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Record, Records


@dataclass(frozen=True, kw_only=True)
class Compensation(Record):
    """A compensation: what its law starts from, and its properties."""

    # makes, for a number of users, the state (a NamedTuple) by whose type the family
    # :data:`pmwvc_core.law.black_box.compensations.compensated` chooses the law
    rest: Callable[[int], Any]
    limits: bool = False  # whether it shortens returning waves: may withhold an environment
    # whether the port returns no more energy than it received, whatever the environment
    passive: Callable[[ServerParams], bool] = lambda params: False
    # energy that it may give out without having received it [J]
    allowance_j: Callable[[ServerParams], float] = lambda params: 0.0
    accounts: tuple[Entry, ...] = ()  # all that it keeps: numbers of its state, in their order


DEFICIT = Entry("debt", "deficit, recovered from later waves", Role.LEVEL)
OF_LEDGER = (
    Entry("tank", "energy tank of the server port", Role.LEVEL),
    Entry("granted", "taken from the allowance", Role.LEVEL),
    Entry("capped", "received above the cap, not stored", Role.LEVEL),
)


UNTREATED = Compensation(
    name="none",
    words="The energy of late decoding is not treated.",
    linear="none",
    rest=lambda users: NOTHING,
)
PRINTED = Compensation(
    name="printed",
    words="The compensation as published: it makes returning waves longer and generates energy.",
    linear="none",
    rest=lambda users: AsPublished((0.0,) * users),
)
CORRECTED = Compensation(
    name="corrected",
    words="Returning waves are shortened by what late decoding added.",
    linear="none",
    rest=lambda users: Corrected(0.0),
    limits=True,
    accounts=(DEFICIT,),
)
LEDGER = Compensation(
    name="ledger",
    words="All users together get back no more energy than they gave, and a declared allowance.",
    linear="none",
    rest=lambda users: JointLedger(0.0, 0.0, 0.0),
    limits=True,
    passive=lambda params: bool(min(params.allowance_w, params.allowance_j) == 0),
    allowance_j=lambda params: float(params.allowance_j) if params.allowance_w > 0.0 else 0.0,
    accounts=OF_LEDGER,
)
COMPENSATIONS: Records[Compensation] = Records(
    Compensation,
    (UNTREATED, PRINTED, CORRECTED, LEDGER),
    group="pmwvc.compensations",
    parameter="server.compensation",
    what="a compensation",
)
