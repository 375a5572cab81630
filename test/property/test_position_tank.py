# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tank of position feedback by itself: reserve for the filter, deficit of the hold."""

import math

import pytest
from support.filter_runs import Held
from support.packer import Packer

from pmwvc_core.ends.inbox import known
from pmwvc_core.law.position.energy_tank import (
    Tank,
    tank_down,
    tank_free_j,
    tank_packet,
    tank_send,
)
from pmwvc_core.made.waves import made_impedance, position_params
from pmwvc_core.params import FilterParams, MasterParams, PositionParams
from pmwvc_core.wave.aliasing import worst_case_gain

M, TICK_S, FRAME_S = 8, 0.001, 0.008
WAVE = 0.3
BROUGHT = WAVE**2 * FRAME_S / 2  # by each packet


class HeldTank:
    """A tank that hears packets of one wave, and the hold that plays them."""

    def __init__(self, kind):
        params = MasterParams(
            rate_drop=M, tick_s=TICK_S, hold=kind, position=PositionParams(most_j=10.0)
        )
        self.p = position_params(params, made_impedance(25.0), strict=False)
        self.s, self.hold = Tank(self.p.lent_j, *((0.0,),) * 4), Held(kind, ticks=M)
        self.server, self.packet = Packer(7, period=FRAME_S), None

    def frame(self, *, late=False, lost=0, silent=False):
        """Run a frame and settle it; return what is free and the deficit [J]."""
        for _ in range(0 if late else lost + 1):  # the last of these comes in
            self.packet = self.server.pack(WAVE, 0.0, 0)
        came = known(self.packet, 1, fresh=False, lost=0)
        self.s = tank_packet(self.s, came, self.p)
        self.hold.load(0.0 if silent else WAVE)
        for _ in range(M):
            v = (self.hold.step(),)
            self.s, _ = tank_down(self.s, (0.0,), v, (0.0,), False, self.p)
        self.s = tank_packet(self.s, came, self.p)
        return tank_free_j(self.s), self.s.deficit_j


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_the_tank_pays_for_what_is_held_and_lost_packets_pay_it_back(hold):
    """Off is what a ramp between 0 and the wave gives out less than the packet brought."""
    held, off = HeldTank(hold), 0.0
    if hold == "foh":
        off = WAVE**2 * TICK_S / 2 * (M * M - 1) / (6 * M)
    for frame, free_j, deficit_j in (
        ({"silent": True}, BROUGHT, 0.0),
        ({"late": True}, off, 0.0),  # the tank has it
        ({"late": True}, 0.0, BROUGHT - off),  # the tank has not all of it
        ({"lost": 1}, off, 0.0),  # what was lost pays that first
        ({"lost": 2}, off + 2.0 * BROUGHT, 0.0),
    ):
        assert held.frame(**frame) == pytest.approx((free_j, deficit_j), rel=1e-12, abs=1e-15)


def test_a_change_of_the_wave_costs_what_it_carries_more_and_what_limits_gave_is_lacking():
    p, s = HeldTank("zoh").p, Tank(0.05, *((0.0,),) * 4)
    for wanted, more in ((0.2, 0.5**2 - 0.3**2), (2.0, 0.05 * 2.0 / 0.1), (-0.2, 0.1**2 - 0.3**2)):
        after, change = tank_down(s, (0.0,), (0.3,), (wanted,), True, p)
        assert (0.3 + change[0]) ** 2 - 0.3**2 == pytest.approx(more)
        assert 0.05 - after.saved_j == pytest.approx(0.5 * TICK_S * more)
    assert tank_free_j(s) == 0.05
    assert tank_free_j(s._replace(device_j=-0.01)) == pytest.approx(0.04)
    assert tank_free_j(s._replace(work_j=-0.02)) == pytest.approx(0.03)


@pytest.mark.parametrize("pole", [5.0, 50.0])
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
    master = MasterParams(rate_drop=M, tick_s=TICK_S, filter=filtering)
    p = position_params(master, made_impedance(25.0), strict=False)
    tank, _ = tank_send(Tank(p.lent_j, *((0.0,),) * 4), (0.1,), p)
    # Nothing was taken in: only the reserve is missing, and no packet goes out.
    assert -tank.saved_j == pytest.approx(k * 0.01, rel=0.02)
