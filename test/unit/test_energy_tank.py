# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy tank of a master: reserve for the filter, deficit of the hold, its repayment."""

import math

import pytest
from support.packer import Packer

from pmwvc_core.ends.inbox import known
from pmwvc_core.law.position.energy_tank import (
    Tank,
    tank_down,
    tank_free_j,
    tank_packet,
    tank_send,
)
from pmwvc_core.law.wave.filter_and_hold import Hold, hold, load
from pmwvc_core.made.waves import made_impedance, position_params
from pmwvc_core.params import FilterParams, MasterParams, PositionParams
from pmwvc_core.wave.aliasing import worst_case_gain

M, TICK_S, FRAME_S = 8, 0.001, 0.008
WAVE = 0.3
BROUGHT = WAVE**2 * FRAME_S / 2  # by each packet


def params_of(**values):
    """Return the parameters of a tank."""
    master = MasterParams(rate_drop=M, tick_s=TICK_S, **values)
    return position_params(master, made_impedance(25.0), strict=False)


class Held:
    """An account that hears packets of one wave, and the hold that plays them."""

    def __init__(self, kind, *, most_j):
        self.p = params_of(hold=kind, position=PositionParams(most_j=most_j))
        self.s, self.ramp = Tank(self.p.lent_j, *((0.0,),) * 4), M if kind == "foh" else 1
        self.hold = Hold((0.0,), (0.0,), (0.0,), 0)
        self.server = Packer(7, period=FRAME_S)
        self.packet = None

    def frame(self, *, late=False, lost=0, silent=False):
        """Run a frame and settle it."""
        for _ in range(0 if late else lost + 1):  # the last of these comes in
            self.packet = self.server.pack(WAVE, 0.0, 0)
        came = known(self.packet, 1, fresh=False, lost=0)
        self.s = tank_packet(self.s, came, self.p)
        self.hold = load(self.hold, (0.0,) if silent else came.wave)
        for _ in range(M):
            self.hold, v = hold(self.hold, self.ramp)
            self.s, _ = tank_down(self.s, (0.0,), v, (0.0,), False, self.p)
        self.s = tank_packet(self.s, came, self.p)

    deficit_j = property(lambda self: self.s.deficit_j)
    free_j = property(lambda self: tank_free_j(self.s))


def rounded_off(hold):
    """Return what a ramp between 0 and the wave gives out less than the packet brought [J]."""
    return WAVE**2 * TICK_S / 2 * (M * M - 1) / (6 * M) if hold == "foh" else 0.0


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_deficit_of_a_held_wave_is_that_of_both_its_ramps(hold):
    """A packet heard in silence, whose energy is let go; later the hold plays it all the same.

    The ramps up and down give out |v|^2 T_c/2 (2 M^2 + 1)/(3 M), the second in a silent frame.
    """
    held = Held(hold, most_j=0.0)
    held.frame(silent=True)
    assert held.deficit_j == 0.0
    held.frame(late=True)
    assert held.deficit_j == pytest.approx(BROUGHT - rounded_off(hold), rel=1e-12)
    held.frame(late=True, silent=True)
    ramps = WAVE**2 * TICK_S / 2 * (2 * M * M + 1) / (3 * M)
    assert held.deficit_j == pytest.approx(ramps if hold == "foh" else BROUGHT, rel=1e-12)
    held.frame(late=True, silent=True)
    assert held.deficit_j == pytest.approx(ramps if hold == "foh" else BROUGHT, rel=1e-12)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_the_tank_pays_for_what_is_held_and_lost_packets_pay_it_back(hold):
    held, off = Held(hold, most_j=10.0), rounded_off(hold)

    def stands(free, deficit_j):
        assert held.free_j == pytest.approx(free, rel=1e-12, abs=1e-15)
        assert held.deficit_j == pytest.approx(deficit_j, rel=1e-12, abs=1e-15)

    held.frame(silent=True)
    stands(BROUGHT, 0.0)
    held.frame(late=True)  # the tank has it
    stands(off, 0.0)
    held.frame(late=True)  # the tank has not all of it
    stands(0.0, BROUGHT - off)
    held.frame(lost=1)  # what was lost pays that first
    stands(off, 0.0)
    held.frame(lost=2)
    stands(off + 2.0 * BROUGHT, 0.0)


@pytest.mark.parametrize("pole", [5.0, 20.0, 50.0])
def test_what_is_kept_for_a_first_order_filter_is_the_most_it_can_still_give(pole):
    """With packets at 1/g^2 of their energy, the largest over all waves that may follow.

    From y, with the wave of a frame h c: y+ = q y + c |h|^2; the best c leaves k y^2 for
    k = (e + k) q^2 i/(i - (e + k) |h|^2), i = T_c/2, e = M T_c/(2 g^2).
    """
    filtering = FilterParams(kind="first_order", pole_rad_s=pole)
    p, i = math.exp(-pole * TICK_S), TICK_S / 2
    q, r = p**M, (1 - p) / (1 + p)
    k = i / r * q / (1 + q)
    e, h2 = FRAME_S / 2 / worst_case_gain(filtering, tick_s=TICK_S, rate_drop=M), r * (1 - q * q)
    assert k == pytest.approx((e + k) * q * q * i / (i - (e + k) * h2), rel=1e-6)
    p = params_of(filter=filtering)
    tank, _ = tank_send(Tank(p.lent_j, *((0.0,),) * 4), (0.1,), p)
    # Nothing was taken in: only the reserve is missing, and no packet goes out.
    assert -tank.saved_j == pytest.approx(k * 0.01, rel=0.02)
