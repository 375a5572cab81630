# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a compensation of the energy of late decoding."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pmwvc_core.account import Entry
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Record


@dataclass(frozen=True, kw_only=True)
class Compensation(Record):
    """A compensation: what its law starts from, and its properties.

    Attributes
    ----------
    rest
        Makes, for a number of users, the state (a NamedTuple) by whose type the family
        :data:`pmwvc_core.law.black_box.compensations.compensated` chooses the law.
    limits
        Whether it shortens returning waves, and so may withhold an environment from a user.
    passive
        Tells whether the port returns no more energy than it received, whatever the environment.
    allowance_j
        Energy that it may give out without having received it [J].
    accounts
        Every account that it keeps: numbers of its state, in their order.
    """

    rest: Callable[[int], Any]
    limits: bool = False
    passive: Callable[[ServerParams], bool] = lambda params: False
    allowance_j: Callable[[ServerParams], float] = lambda params: 0.0
    accounts: tuple[Entry, ...] = ()
