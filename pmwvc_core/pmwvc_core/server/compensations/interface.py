# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What every compensation offers, and the one that does nothing."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from pmwvc_core.numeric import Value


class Wave(NamedTuple):
    """What went through one user's port in a step."""

    user: int
    u: Value  # (..., dof) [sqrt(W)] received
    v: Value  # (..., dof) [sqrt(W)] to be returned
    late: Value  # (..., 1) [W] F . (xd as it should have been - xd as decoded), mostly < 0


class Compensation(Protocol):
    """Changes the waves that go back; keeps its own account."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Its energies by name [J]; always the same names."""
        ...

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves to send instead of ``v``.

        ``stored`` is what can still come out of environment and decoding [J], None where the
        environment does not say.
        """
        ...


class Untreated:
    """Send what came out."""

    accounts: Mapping[str, Value] = {}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return ``v``."""
        return [wave.v for wave in waves]
