# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The port filters of the linear model: velocity filters, position feedback.

The equations are those of ``velocity_filter`` (:mod:`pmwvc_core.master.port_filters`) and
:mod:`pmwvc_core.master.position`, applied to rows (:mod:`.blocks`). A part lets ``down(v)``
through of the wave from the server, says in ``offer`` how it will answer, v0 + g u, and in
``step`` what of u goes on.
"""

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from oracle.linear_model.bank import Bank
from oracle.linear_model.blocks import Block, column
from oracle.linear_model.sections import Sections

from pmwvc_core.numeric import Array
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.velocity_filter_design import passing


class Part(Protocol):
    """A part of the wave port."""

    @property
    def blocks(self) -> Mapping[str, Block]:
        """What has states, by name."""

    def down(self, v: Array) -> Array:
        """Return what passes of the wave from the server, once a tick."""

    def offer(self) -> tuple[Array, Array]:
        """Return v0 and g of the answer v0 + g u."""

    def step(self, u: Array) -> Array:
        """Take the outgoing wave; return what goes on."""

    def steady(self, u: Array) -> list[Array]:
        """Return the states of all blocks while waves u go both ways."""


class FedBack:
    """v_m = w + s H_HP u: the exact velocity filter."""

    def __init__(self, params: MasterParams) -> None:
        self._share = column(params.velocity_filter.share)
        self._high = Sections(passing(params, "high"))
        self.blocks: dict[str, Block] = {"velocity_filter.": self._high}

    def down(self, v: Array) -> Array:
        """Let all pass."""
        return v

    def offer(self) -> tuple[Array, Array]:
        """Return what the high-pass branch will feed back."""
        return self._share * self._high.rest(), self._share * self._high.gain

    def step(self, u: Array) -> Array:
        """Advance; all goes on."""
        self._high.step(u)
        return u

    def steady(self, u: Array) -> list[Array]:
        """Return the states of the filter."""
        return self._high.steady(u)


class SplitBothWays:
    """v_m = H_1 w + s H_2 H_2 u, and H_1 u goes on: the complementary velocity filter."""

    def __init__(self, params: MasterParams) -> None:
        self._share = column(params.velocity_filter.share)
        low, high = passing(params, "low"), passing(params, "high")
        self._up, self._down = Sections(low), Sections(low)
        self._first, self._second = Sections(high), Sections(high)
        self.blocks: dict[str, Block] = {
            "velocity_filter.up.": self._up,
            "velocity_filter.down.": self._down,
            "velocity_filter.first.": self._first,
            "velocity_filter.second.": self._second,
        }

    def down(self, v: Array) -> Array:
        """Return the low-pass branch of the wave."""
        return self._down.step(v)

    def offer(self) -> tuple[Array, Array]:
        """Return what the two high-pass filters will feed back."""
        rest = self._second.gain * self._first.rest() + self._second.rest()
        return self._share * rest, self._share * self._first.gain * self._second.gain

    def step(self, u: Array) -> Array:
        """Advance; return the low-pass branch."""
        self._second.step(self._first.step(u))
        return self._up.step(u)

    def steady(self, u: Array) -> list[Array]:
        """Return the states of the four filters; at rest the low-pass ones let all pass."""
        first = self._first.at_rest(u)
        return [
            *self._up.steady(u),
            *self._down.steady(u),
            *self._first.steady(u),
            *self._second.steady(first),
        ]


def make_parts(params: MasterParams) -> list[Part]:
    """Return the parts that the parameters name, the one nearest to the device first."""
    found: list[Part] = []
    if params.velocity_filter.kind == "exact":
        found.append(FedBack(params))
    elif params.velocity_filter.kind == "complementary":
        found.append(SplitBothWays(params))
    if params.bank.kind != "none":
        found.append(Bank(params))
    return found


class LessVelocity:
    """(1 - 2 s H_HP) xd in the force: the equivalent velocity filter."""

    def __init__(self, params: MasterParams) -> None:
        self._twice = 2.0 * column(params.velocity_filter.share)
        self._high = Sections(passing(params, "high"))
        self.names = self._high.names

    @property
    def state(self) -> list[Array]:
        """One row per name."""
        return self._high.state

    @state.setter
    def state(self, rows: list[Array]) -> None:
        self._high.state = rows

    def step(self, xd: Array) -> Array:
        """Return the velocity for the force of a tick."""
        return xd - self._twice * self._high.step(xd)

    def steady(self, xd: Array) -> list[Array]:
        """Return the states in uniform motion."""
        return self._high.steady(xd)


class Feedback:
    """- K_p (x_m - x_s) on the returning wave, x_s of the newest packet (App. E, Eq. 3).

    Taken at the start of a frame, a packet leaves nothing behind.
    """

    def __init__(self, params: MasterParams, *, phase: int) -> None:
        self.gain = column(params.position.gain)
        self.names: tuple[str, ...] = ("x_s",) if phase else ()
        self._x_s: Array = np.zeros((1, 1))

    @property
    def state(self) -> list[Array]:
        """One row per name."""
        return [self._x_s][: len(self.names)]

    @state.setter
    def state(self, rows: list[Array]) -> None:
        if rows:
            self._x_s = rows[0]

    def on_packet(self, x_s: Array) -> None:
        """Take the avatar's position from a packet."""
        self._x_s = x_s

    def down(self, v: Array, x: Array) -> Array:
        """Return the wave with the feedback."""
        return v - self.gain * (x - self._x_s)

    def steady(self, x_s: Array) -> list[Array]:
        """Return the state while the avatar is heard to be there."""
        return [x_s][: len(self.names)]
