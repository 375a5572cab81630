# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""No compensation: waves go back as they come out."""

from collections.abc import Mapping, Sequence

from pmwvc_core.numeric import Value
from pmwvc_core.server.compensations.record import Compensation, Wave
from pmwvc_core.state import Stateful


class Untreated(Stateful):
    """Send what came out."""

    accounts: Mapping[str, Value] = {}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return ``v``."""
        return [wave.v for wave in waves]


RECORD = Compensation(
    name="none",
    words="The energy of late decoding is not treated.",
    linear="none",
    make=lambda params, users: Untreated(),
)
