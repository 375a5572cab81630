# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filter bank with a local spring and damper as a part of the linear model (App. E).

The equations are those of ``filter_bank`` and ``local_model``
(:mod:`pmwvc_core.master.port_filters`), applied to rows (:mod:`.blocks`); what a part is stands in
:mod:`.around`.
"""

import numpy as np
from oracle.linear_model.blocks import Block, Kept, column
from oracle.linear_model.sections import Sections

from pmwvc_core.numeric import Array
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.filter_design import bank_filters


class Bank:
    """Filter bank with a local spring and damper on the high branch (App. E)."""

    def __init__(self, params: MasterParams) -> None:
        filters, local = bank_filters(params.bank, tick_s=params.tick_s), params.local_model
        self._high_up, self._high_down = Sections(filters.high_up), Sections(filters.high_down)
        self._low_up = None if filters.low_up is None else Sections(filters.low_up)
        self._low_down = None if filters.low_down is None else Sections(filters.low_down)
        self._spring = Kept(("x",))  # deflection in the local model
        self._tick_s = params.tick_s
        self.stiffness = column(local.stiffness)
        b, slope = column(params.impedance), 0.5 * params.tick_s * self.stiffness
        self._b, self._slope, self._ratio = b, slope + column(local.damping), np.sqrt(2.0 / b)
        self._share = 1.0 + self._slope / b
        self.blocks: dict[str, Block] = {
            "bank.high_up.": self._high_up,
            "bank.high_down.": self._high_down,
            "bank.local.": self._spring,
        }
        for name, low in (("up", self._low_up), ("down", self._low_down)):
            if low is not None:
                self.blocks[f"bank.low_{name}."] = low

    def down(self, v: Array) -> Array:
        """Return the low branch of the wave."""
        return v if self._low_down is None else self._low_down.step(v)

    def offer(self) -> tuple[Array, Array]:
        """Return what the local model will answer through the high branch."""
        up, down = self._high_up, self._high_down
        v0 = -self._ratio * self.stiffness * self._spring.state[0] / self._share
        gain = (self._b - self._slope) / (self._b + self._slope)
        return down.rest() + down.gain * (v0 + gain * up.rest()), gain * up.gain * down.gain

    def step(self, u: Array) -> Array:
        """Have the local model answer; return the low branch."""
        high = self._high_up.step(u)
        x = self._spring.state[0]
        force = (self.stiffness * x + self._ratio * self._slope * high) / self._share
        self._high_down.step(high - self._ratio * force)
        self._spring.state = [x + self._tick_s * (self._ratio * high - force / self._b)]
        return u if self._low_up is None else self._low_up.step(u)

    def steady(self, u: Array) -> list[Array]:
        """Return the states; nothing of a constant wave comes to the local model."""
        found = [*self._high_up.steady(u), *self._high_down.steady(0.0 * u), 0.0 * u]
        for low in (self._low_up, self._low_down):
            found += [] if low is None else low.steady(u)
        return found
