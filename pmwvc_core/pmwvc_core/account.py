# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy accounts of blocks [J], stated beside each block's law.

::

    taken = given + stored + dissipated + residual

Drawn up from recorded signals at the ends of a block (:class:`Account`, :class:`Passage`), or kept
by the block while it runs, where no signal shows it (:class:`Entry`). Signals are those of one
step, or the rows of a trace ``(..., n, dof)``; then energies are ``(..., n, 1)``.
"""

import enum
from collections.abc import Mapping
from typing import NamedTuple

from pmwvc_core.numeric import Array, Integers, Value, squared


class Account(NamedTuple):
    """Energy of a block over a step, or since the start [J]."""

    taken: Value  # came in at one end
    given: Value = 0.0  # went out at the other
    stored: Value = 0.0  # by how much what the block holds has grown
    dissipated: Value = 0.0  # turned into heat, or dropped

    @property
    def residual(self) -> Value:
        """Energy that storage and dissipation, computed independently, do not explain [J]."""
        return self.taken - self.given - self.stored - self.dissipated


class Passage(NamedTuple):
    """The account of a block by the names of its energies (several are added); ``part`` is that of
    an energy budget that the others leave over.
    """

    part: str
    taken: tuple[str, ...]
    given: tuple[str, ...]
    stored: tuple[str, ...] = ()
    dissipated: tuple[str, ...] = ()

    def account(self, energies: Mapping[str, Value]) -> Account:
        """Return the account of the block from the energies by their names [J]."""
        return Account(*(sum(energies[each] for each in names) for names in self[1:]))


class Role(enum.Enum):
    """The role of a kept account in the balance of its owner."""

    TAKEN = enum.auto()  # taken in and not given on, less what was given out again
    GIVEN = enum.auto()  # given out
    WITHIN = enum.auto()  # contained in other accounts
    LEVEL = enum.auto()  # energy held, lacking or allowed: no part of the balance
    SHOWN = enum.auto()  # follows from signals as well


class Entry(NamedTuple):
    """An account that a block keeps while it runs, as its ``accounts`` name it."""

    name: str
    words: str
    role: Role
    part: str = ""  # its block in an energy budget; the same words by default

    @property
    def sign(self) -> int:
        """1 or -1 for a part of an energy budget, 0 for none."""
        return {Role.TAKEN: 1, Role.GIVEN: -1}.get(self.role, 0)


def wave_energy(wave: Value, dt: float) -> Value:
    """Return the energy of a wave [sqrt(W)] that lasts dt [s], |w|^2 dt/2 [J]."""
    return squared(wave) * (0.5 * dt)


def continued(sums: Array, rows: Integers) -> Array:
    """Return running sums that go on where, in these rows, they start again at zero."""
    result = sums.copy()
    for row in rows:
        result[row:] += result[row - 1] - (result[row] - sums[row])
    return result
