# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy accounts of a black box and its port, of all users together.

::

    environment    sum F . xd h
    late_decoding  sum d h, with the power d of decoding with another force than F
    withheld       what the compensation took from the returning waves (negative: added)
    contained      sum |u|^2 h/2 while the environment did not answer and the port was a damper

Their sum is what went in at the ports, less the heat of the avatars' brakes.
"""

from pmwvc_core.account import Entry, Passage, Role
from pmwvc_core.numeric import Value
from pmwvc_core.state import Stateful

ENTRIES = (
    Entry("environment", "taken by the environment", Role.SHOWN),
    Entry("late_decoding", "decoding with the force of the previous step", Role.SHOWN),
    Entry(
        "withheld",
        "withheld by the compensation",
        Role.SHOWN,
        part="compensation of the server port",
    ),
    Entry(
        "contained",
        "dissipated in place of a failed environment",
        Role.SHOWN,
        part="damper in place of a failed environment",
    ),
)

# Between what went in at the ports, less the heat of the avatars' brakes, and the work of the
# forces at the avatars; and what the environment does not report as stored.
PORT = Passage("residual", ("ports",), ("avatars",), (), ("late_decoding", "withheld"))
ENVIRONMENT = Passage("environment_heat", ("avatars",), ("contained",), ("reported",))


class BlackBoxAccounts(Stateful):
    """The sums so far [J], by name; ``(runs, 1)`` in a batch."""

    MEMORY = "sums"

    def __init__(self) -> None:
        self.sums: dict[str, Value] = dict.fromkeys((entry.name for entry in ENTRIES), 0.0)

    def add(self, name: str, power: Value, dt: float) -> None:
        """Count a power [W] that lasted dt [s]."""
        self.sums[name] = self.sums[name] + dt * power

    @property
    def spent(self) -> Value:
        """What the environment took, and the damper in its place [J]."""
        return self.sums["environment"] + self.sums["contained"]
