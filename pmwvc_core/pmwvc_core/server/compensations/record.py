# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a compensation of the energy of late decoding, and the one that does nothing."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from pmwvc_core.account import Entry
from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Record
from pmwvc_core.state import Stateful


class Wave(NamedTuple):
    """The signals of one user's port in a step."""

    user: int
    u: Value  # (..., dof) [sqrt(W)] received
    v: Value  # (..., dof) [sqrt(W)] to be returned
    late: Value  # (..., 1) [W] F . (xd as it should have been - xd as decoded), mostly < 0


class Treatment(Protocol):
    """Changes the waves that go back; keeps its own account."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Its energies by name [J]; always the same names."""
        ...

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves to send instead of ``v``.

        ``stored`` is what can still come out of environment and decoding [J], None where the
        environment does not report it.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Compensation(Record):
    """A compensation: what makes its treatment of waves, and its properties.

    Attributes
    ----------
    make
        Makes the treatment, for a number of users.
    limits
        Whether it shortens returning waves, and so may withhold an environment from a user.
    passive
        Tells whether the port returns no more energy than it received, whatever the environment.
    allowance_j
        Energy that it may give out without having received it [J].
    accounts
        Every account that it keeps.
    """

    make: Callable[[ServerParams, int], Treatment]
    limits: bool = False
    passive: Callable[[ServerParams], bool] = lambda params: False
    allowance_j: Callable[[ServerParams], float] = lambda params: 0.0
    accounts: tuple[Entry, ...] = ()


class Untreated(Stateful):
    """Send what came out."""

    accounts: Mapping[str, Value] = {}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return ``v``."""
        return [wave.v for wave in waves]


UNTREATED = Compensation(
    name="none",
    words="The energy of late decoding is not treated.",
    linear="none",
    make=lambda params, users: Untreated(),
)
