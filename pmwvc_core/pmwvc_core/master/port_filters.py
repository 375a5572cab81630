# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filters between the device and the link, as seen from the wave port.

A filter takes the outgoing wave u_m of every tick, keeps part of it and answers within the tick.
Before that it states its answer as a function of the wave, v = v0 + g u_m with |g| < 1, so that
the port can solve the loop through the device's velocity.
"""

from collections.abc import Mapping
from typing import Protocol

from pmwvc_core.master.velocity_filter import make_velocity_filter
from pmwvc_core.numeric import Value
from pmwvc_core.params import MasterParams


class PortFilter(Protocol):
    """One part. Order within a tick: ``down``, ``offer``, ``step``."""

    def down(self, v: Value) -> Value:
        """Return what this part lets through of the wave from the server, once a tick."""

    def offer(self) -> tuple[Value, Value]:
        """Return v0 [sqrt(W)] and g of the answer v0 + g u_m, g per axis or one for all."""

    def step(self, u: Value) -> Value:
        """Take the outgoing wave as it is; return what of it goes on to the server."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of this part since the start, by name [J]; always the same names."""


def make_port_filters(params: MasterParams, bank: PortFilter | None) -> list[PortFilter]:
    """Return the parts that the parameters name, the one nearest to the device first."""
    made: tuple[PortFilter | None, ...] = (make_velocity_filter(params), bank)
    return [part for part in made if part is not None]
