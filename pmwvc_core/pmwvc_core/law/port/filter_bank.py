# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter bank with a local model on the high-pass part of the outgoing wave (App. E).

Fig. 3::

    u_m --> low_up ---> anti-aliasing filter, packets --> server
        '-> high_up --> u2 --> local model --> v2 --> high_down -,
    v_m <---------------- w <-- low_down <-- hold <-- server --(+)

``dissertation``: low_up and low_down are wires, high_up is HP, high_down is LP2. The returning
wave is bounded only by (|LP1| + |LP2| |HP|) |u_m|, above 1 for the filters of Table 1.

``complementary``: one first-order pair splits and recombines, |H1|^2 + |H2|^2 = 1. Then |u1|^2 +
|u2|^2 <= |u_m|^2 and |H1 v1 + H2 v2|^2 <= |v1|^2 + |v2|^2: passive for any passive server and
local model.

The local model answers within the tick: v_m = w + v0 + g u_m with g = HD (b - G)/(b + G) HU.

Equations: docs/theory.md 8.4.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.port import port_filters
from pmwvc_core.law.port.local_model import (
    local_answer,
    local_offer,
    local_stored_j,
    resting_local,
)
from pmwvc_core.law.vectors import Vector, columns, each, plus, scaled
from pmwvc_core.law.wave.cascade import (
    Cascade,
    Sections,
    cascade,
    gain_of,
    rest_of,
    resting_cascade,
    sections_of,
)
from pmwvc_core.law.wave.wave import along, wave_j
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.design.bank_design import bank_filters


class BankEnergies(NamedTuple):
    """Energies of the waves of either branch, to and from server and local model [J]."""

    low_in: float
    low_out: float
    high_in: float
    high_out: float


class Bank(NamedTuple):
    """The filters of every axis, and the local model."""

    low_up: tuple[Cascade, ...]
    low_down: tuple[Cascade, ...]
    high_up: tuple[Cascade, ...]
    high_down: tuple[Cascade, ...]
    local: Any
    energies: BankEnergies


class BankFilters(NamedTuple):
    """The filters; one without sections is a wire."""

    low_up: Sections
    low_down: Sections
    high_up: Sections
    high_down: Sections
    local: Any
    tick_s: float


def bank_of(master: MasterParams, local: Any) -> BankFilters:
    """Return the parameters of the bank of a master around a local model."""
    found = bank_filters(master.bank, tick_s=master.tick_s)
    return BankFilters(
        () if found.low_up is None else sections_of(found.low_up),
        () if found.low_down is None else sections_of(found.low_down),
        sections_of(found.high_up),
        sections_of(found.high_down),
        local,
        master.tick_s,
    )


def resting_bank(axes: int, p: BankFilters) -> Bank:
    """Return a bank at rest."""
    return Bank(
        (resting_cascade(p.low_up),) * axes,
        (resting_cascade(p.low_down),) * axes,
        (resting_cascade(p.high_up),) * axes,
        (resting_cascade(p.high_down),) * axes,
        resting_local(p.local, axes),
        BankEnergies(0.0, 0.0, 0.0, 0.0),
    )


@port_filters.part_down.member(Bank)
def _bank_down(s: Bank, v: Vector, p: BankFilters) -> tuple[Bank, Vector]:
    e = s.energies
    energies = e._replace(low_out=e.low_out + wave_j(v, p.tick_s))
    low_down, w = columns(each(cascade, (s.low_down, v), p.low_down))
    return s._replace(low_down=low_down, energies=energies), w


@port_filters.part_offer.member(Bank)
def _bank_offer(s: Bank, x: Vector, p: BankFilters, impedance: Any) -> tuple[Bank, Vector, Vector]:
    local, v0, gains = local_offer(s.local, x, p.local, impedance)
    up, down = each(rest_of, (s.high_up,), p.high_up), each(rest_of, (s.high_down,), p.high_down)
    answer = plus(down, scaled(plus(v0, along(impedance, gains, up)), gain_of(p.high_down)))
    through = each(_through, (gains,), gain_of(p.high_up) * gain_of(p.high_down))
    return s._replace(local=local), answer, through


def _through(gain: float, of_filters: float) -> float:
    return gain * of_filters


@port_filters.part_up.member(Bank)
def _bank_up(s: Bank, u: Vector, p: BankFilters, impedance: Any) -> tuple[Bank, Vector]:
    high_up, u2 = columns(each(cascade, (s.high_up, u), p.high_up))
    local, v2 = local_answer(s.local, u2, p.local, impedance)
    high_down, _ = columns(each(cascade, (s.high_down, v2), p.high_down))
    low_up, low = columns(each(cascade, (s.low_up, u), p.low_up))
    e, h = s.energies, p.tick_s
    energies = BankEnergies(
        e.low_in + wave_j(low, h), e.low_out, e.high_in + wave_j(u2, h), e.high_out + wave_j(v2, h)
    )
    return Bank(low_up, s.low_down, high_up, high_down, local, energies), low


@port_filters.part_energies.member(Bank)
def _bank_energies(s: Bank, p: BankFilters) -> Vector:
    e, local, stored_j = s.energies, s.local, local_stored_j(s.local, p.local)
    return e.low_in, e.low_out, e.high_in, e.high_out, stored_j, local.dissipated_j
