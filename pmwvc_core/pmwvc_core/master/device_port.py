# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave port of a device with what stands around it, on either channel.

Port filters (:mod:`.port_filters`: velocity filter, filter bank) let through w of the returning
wave v and answer u_m on the spot, so that

    v_m = w + g u_m,   u_m = (sqrt(2b) xd - w)/(1 + g)

Without them v_m = v. What gives v and takes u_m on is the channel's: :mod:`.port` (plain),
:mod:`.strict_port` (strict).
"""

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Protocol

from pmwvc_core.master.port_filters.filter_bank import make_bank
from pmwvc_core.master.port_filters.velocity_filter import (
    EquivalentVelocityFilter,
    make_force_velocity,
    make_velocity_filter,
)
from pmwvc_core.numeric import Value, absolute, finite, where
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.impedance import impedance_of
from pmwvc_core.wave.transform import WavePort


class PortFilter(Protocol):
    """A filter between device and link; order within a tick: ``down``, ``offer``, ``step``.

    It takes the outgoing wave u_m of every tick, keeps part of it and answers within the tick.
    Before that it states its answer as a function of the wave, v = v0 + g u_m with |g| < 1, so
    that the port can solve the loop through the device's velocity.
    """

    def down(self, v: Value) -> Value:
        """Return what this part lets through of the wave from the server, once a tick."""

    def offer(self) -> tuple[Value, Value]:
        """Return v0 [sqrt(W)] and g of the answer v0 + g u_m, g per axis or one for all."""

    def step(self, u: Value) -> Value:
        """Take the outgoing wave as it is; return what of it goes on to the server."""

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of this part since the start, by name [J]; always the same names."""


class DevicePort(Stateful, ABC):
    """The wave port of a device; see the module. At rest, with both waves zero, at first.

    Parameters
    ----------
    params
        Impedance, rate drop, and what stands around the port; numbers may be ``(runs, 1)``.
    """

    BLOCKS = "_port_filters _velocity"
    MEMORY = "u_m u_m_lp v_m f_m _x _held _gain _before"
    flags = 0

    def __init__(self, params: MasterParams) -> None:
        self.params: MasterParams = params
        self._before: dict[str, Value] = {}
        self._port_filters: list[PortFilter] = []
        self._velocity: EquivalentVelocityFilter | None = None
        self._bank = make_bank(params, self.position)
        self._begin(params)
        self.u_m: Value = 0.0
        self.u_m_lp: Value = 0.0
        self.v_m: Value = 0.0
        self.f_m: Value = 0.0
        self._x: Value = 0.0
        self._held: Value = 0.0  # w: what is in v_m whatever u_m
        self._gain: Value = 0.0  # g

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over at a frame start; the tick stays.

        Waves carry the same power whatever the impedance, so that may change at any time, and so
        may position feedback, local model, and what is the frame's: rate drop and deadband. Port
        filters keep the design for the rate at which they began. Another filter, hold or part
        starts at zero: what the old one held is lost, never gained.
        """
        old = self.params
        same = dataclasses.replace(
            params,
            impedance=old.impedance,
            position=old.position,
            bank=old.bank,
            local_model=old.local_model,
            rate_drop=old.rate_drop,
            deadband=old.deadband,
        )
        if same == old:
            self.params = params
            self._match(params)
        else:
            self._begin(params)
        if self._bank:
            self._bank.configure(params)
        self._configure_position(params)

    def _begin(self, params: MasterParams) -> None:
        """Start the channel and what is around the port at rest; accounts go on."""
        self._before = self._between()
        self.params = params
        self._match(params)
        self._tick_s, self._half_s = params.tick_s, 0.5 * params.tick_s
        self._begin_channel(params)
        parts: tuple[PortFilter | None, ...] = (make_velocity_filter(params), self._bank)
        self._port_filters = [part for part in parts if part is not None]  # nearest first
        self._velocity = make_force_velocity(params)

    @abstractmethod
    def _begin_channel(self, params: MasterParams) -> None:
        """Start the channel's own blocks at rest."""

    @abstractmethod
    def _configure_position(self, params: MasterParams) -> None:
        """Give position feedback its parameters; make it where there was none."""

    def _match(self, params: MasterParams) -> None:
        self._port = WavePort(impedance_of(params))

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of velocity filter and filter bank [J]."""
        found = self._between()
        if self._bank:
            found |= self._bank.accounts
        return found

    def _between(self) -> dict[str, Value]:
        """Return the energies of what starts anew, with what went before a change of it [J]."""
        if not self._port_filters and not self._velocity:
            return {}
        found = [each.accounts for each in self._port_filters if each is not self._bank]
        if self._velocity:
            found.append(self._velocity.accounts)
        before = self._before
        return {
            name: before.get(name, 0.0) + value
            for accounts in found
            for name, value in accounts.items()
        }

    def measure(self, x: Value, xd: Value) -> None:
        """Note the position, so that a packet sent before the first tick has it."""
        self._x, _ = self._sensed(x, xd)

    def position(self) -> Value:
        """Return the position last measured [m]."""
        return self._x

    def _sensed(self, x: Value, xd: Value) -> tuple[Value, Value]:
        """Return position and velocity; what is not finite counts as the last position and as no
        velocity.
        """
        both = x + xd
        if math.isfinite(both) if type(both) is float else finite(both):
            return x, xd
        found = absolute(x) < math.inf, absolute(xd) < math.inf
        return where(found[0], x, self._x), where(found[1], xd, 0.0)

    def _answered(self, v: Value, xd: Value) -> Value:
        """Return v_m with the answer of the parts to the wave that fits it."""
        gain: Value = 0.0
        answer: Value = 0.0
        for each in reversed(self._port_filters):
            v = each.down(v)
            own, slope = each.offer()
            answer, gain = answer + own, gain + slope
        self._held, self._gain = v + answer, gain
        natural = self._port.u(xd, self._held)
        return self._held + gain * natural / (1.0 + gain)
