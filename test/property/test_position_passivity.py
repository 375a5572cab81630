# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback that is paid for gives out no more than packets and hand have brought.

The account here is kept from what goes through the ends alone: packets received (with the energy
that their sender has sent so far), force times velocity of the device, packets sent; and for the
deficit of the hold, what a hold alone gives out of the same loads.
The tank by itself: ``test_position_tank.py``.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.filter_runs import Held
from support.law_rigs import ForceLimits
from support.packer import Packer
from support.port_rig import Port

from pmwvc_core.ends.inbox import value
from pmwvc_core.params import FilterParams, MasterParams, PositionParams

M, TICK_S, FRAME_S = 8, 0.001, 0.008
PAID = ("budgeted", "integral")
seeds = st.integers(0, 2**32 - 1)
masters = st.builds(
    MasterParams,
    impedance=st.floats(0.5, 200.0),
    rate_drop=st.just(M),
    hold=st.sampled_from(["zoh", "foh"]),
    filter=st.sampled_from(
        [
            FilterParams(kind="first_order", pole_rad_s=50.0),
            FilterParams(kind="first_order", pole_rad_s=400.0),
            FilterParams(kind="integrate_and_dump"),
            FilterParams(kind="none"),
            FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0),
        ]
    ),
    position=st.builds(
        PositionParams,
        feedback=st.sampled_from(PAID),
        gain=st.floats(0.1, 200.0),
        most_j=st.sampled_from([0.0, 1e-3, 0.05, 10.0]),
    ),
)


def energy_j(wave, time_s):
    return 0.5 * time_s * float(np.dot(wave, wave))


class Ends:
    """A master between an invented server and an invented hand, and the account of its ends."""

    def __init__(self, params, axes, seed):
        self.port = Port(params, axes=axes)
        self.server = Packer(7, period=params.frame_s)
        self.rng, self.axes = np.random.default_rng(seed), axes
        self.plain = Held(params.hold, ticks=M, axes=axes)  # the same hold, alone
        self.brought = self.hand = self.sent = self.played = 0.0
        self.repeated = self.beyond = self.in_hold = 0.0
        self.x, self.xd = self.draw(0.01), self.draw(0.1)
        self.packet, self.before = None, 0.0  # what was sent to nobody, before the first [J]
        self.packets = 0  # sent

    def draw(self, scale):
        return value(tuple(self.rng.normal(0.0, scale, self.axes).tolist()))

    def frame(self, change, *, wave, lost=0, late=False, ticks=M, silent=False):
        """Send, hear (where the packet is not late), and run the ticks."""
        self.sent += energy_j(self.port.send(), FRAME_S)
        self.packets += 1
        for _ in range(lost + 1):  # the last of these comes in
            self.server.pack(self.draw(wave), self.draw(0.02), 0)
        brought, played = self.brought, self.played
        if self.packet is None or not late:
            first, echo = self.packet is None, (max(self.packets - 2, 0), 0, 0)
            self.packet = self.server.pack(self.draw(wave), self.draw(0.02), 0, echo=echo)
            if first:
                own = energy_j(self.packet.wave, self.packet.period)
                self.before = float(np.sum(self.packet.energy)) - own
            self.brought = float(np.sum(self.packet.energy)) - self.before
        elif not silent:
            self.repeated += energy_j(self.packet.wave, FRAME_S)
        self.port.on_packet(self.packet)
        if silent:
            self.port.silence()
            self.plain.load(0.0 * self.packet.wave)
        else:
            self.port.receive(self.packet.wave)
            self.plain.load(self.packet.wave)
        for _ in range(ticks):
            self.tick(change)
        self.beyond += (self.played - played) - (self.brought - brought)
        self.beyond = max(self.beyond, 0.0)

    def tick(self, change):
        self.xd = 0.97 * self.xd + self.draw(0.05)
        f = change(self.port.step(self.x, self.xd), self.xd)
        self.port.applied(f)
        self.hand += float(np.dot(f, self.xd)) * TICK_S
        self.x = self.x + self.xd * TICK_S
        v = self.plain.step()
        self.played += energy_j(v, TICK_S)
        self.in_hold = energy_j(v, TICK_S * (self.plain.ticks - 1) / 2)  # at most

    @property
    def balance(self):
        return self.brought + self.hand - self.sent

    @property
    def largest_deficit(self):
        """The most that loads give out and no packet brought.

        A load gives out no more than the packet it stands for would bring, in its own frame and
        the next (a ramp goes on into that one, silent or not). And the deficit is no more than
        the hold gave out beyond what came in since some packet, and still may.
        """
        return min(self.repeated, self.beyond + self.in_hold)

    def tolerance(self):
        return 1e-11 * (1.0 + self.brought + self.sent + abs(self.hand))


def untouched(ends, rng):
    return lambda asked, xd: asked


def limited(ends, rng):
    force, slew = rng.uniform(0.05, 20.0), rng.uniform(1.0, 20000.0)
    safety = ForceLimits(axes=ends.axes, max_force=force, max_slew=slew, soft_start_s=0.02)
    return lambda asked, xd: safety(asked, xd, x=xd)


def anything(ends, rng):
    force = rng.uniform(0.1, 30.0)
    return lambda asked, xd: ends.draw(force)


@pytest.mark.parametrize("change", [untouched, limited, anything])
@pytest.mark.parametrize("bad", [0.0, 0.4])
@settings(max_examples=8)  # each of 320 ticks
@given(masters, st.sampled_from([1, 2, 6]), seeds, st.sampled_from([0.01, 0.3, 3.0]))
def test_no_energy_is_made_but_the_deficit_of_the_hold_and_the_debt_of_a_force(
    change, bad, params, axes, seed, wave
):
    """On a link in time there is no deficit of the hold; a force let through leaves no debt."""
    ends = Ends(params, axes, seed)
    rng = ends.rng
    change = change(ends, rng)
    early = rng.random() < 0.5
    for _ in range(40):
        ends.frame(
            change,
            wave=wave,
            lost=int(rng.random() < bad) * int(rng.integers(1, 4)),
            late=rng.random() < bad,
            silent=rng.random() < 0.3 * bad,
            ticks=int(rng.integers(1, M + 1)) if early else M,
        )
        if bad:
            ends.port.settle()
        owed, debt = ends.port.energies["position_owed"], ends.port.s.deficit_j
        assert ends.balance + owed + debt >= -ends.tolerance()
        assert owed <= ends.largest_deficit * bool(bad) + ends.tolerance()
        assert 0.0 <= ends.port.energies["position_surplus"] <= params.position.most_j + 1e-12


@pytest.mark.parametrize("gain", [5.0, 100.0])
def test_control_the_published_feedback_makes_energy(gain):
    """An avatar that stands away and pushes: what pulls the device to it is paid by nobody."""
    made = {}
    for kind in ("printed", *PAID):
        params = MasterParams(position=PositionParams(feedback=kind, gain=gain))
        port, server = Port(params), Packer(7, period=FRAME_S)
        x, hand, sent = 0.0, 0.0, 0.0
        for frame in range(60):
            sent += port.send() ** 2 * FRAME_S / 2
            packet = server.pack(0.0, -0.01 if frame else 0.0, 0, echo=(frame + 1, 0, 0))
            port.on_packet(packet)
            port.receive(packet.wave)
            for _ in range(M):
                xd = -0.02
                f = port.step(x, xd)
                port.applied(f)
                hand += f * xd * TICK_S
                x += xd * TICK_S * (x > -0.005)
        made[kind] = sent - packet.energy - hand
    assert made["printed"] > 1e-5
    assert max(made[kind] for kind in PAID) <= 1e-15
