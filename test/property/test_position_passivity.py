# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback that is paid for gives out no more than packets and hand have brought.

The account here is kept from what goes through the ends alone: packets received (with the energy
that their sender has sent so far), force times velocity of the device, packets sent; and for the
deficit of the hold, what a hold alone gives out of the same loads.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.filter_runs import Held
from support.law_rigs import ForceLimits, Port
from support.packer import Packer

from pmwvc_core.ends.inbox import value
from pmwvc_core.params import FilterParams, MasterParams, PositionParams

TICK_S = 0.001
M = 8
PAID = ("budgeted", "integral")
FILTERS = (
    FilterParams(kind="first_order", pole_rad_s=50.0),
    FilterParams(kind="first_order", pole_rad_s=400.0),
    FilterParams(kind="integrate_and_dump"),
    FilterParams(kind="none"),
    FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0),
)

seeds = st.integers(0, 2**32 - 1)
dofs = st.sampled_from([1, 2, 6])
gains = st.floats(0.1, 200.0)
filters = st.sampled_from(FILTERS)
holds = st.sampled_from(["zoh", "foh"])
impedances = st.floats(0.5, 200.0)


def masters(kind):
    """Draw the parameters of masters with a feedback, on some filter and hold."""
    return st.builds(
        lambda b, gain, filtering, hold, most: MasterParams(
            impedance=b,
            rate_drop=M,
            hold=hold,
            filter=filtering,
            position=PositionParams(feedback=kind, gain=gain, most_j=most),
        ),
        impedances,
        gains,
        filters,
        holds,
        st.sampled_from([0.0, 1e-3, 0.05, 10.0]),
    )


def energy_j(wave, time_s):
    return 0.5 * time_s * float(np.dot(wave, wave))


class Ends:
    """A master between an invented server and an invented hand, and the account of its ends."""

    def __init__(self, params, axes, seed):
        self.port = Port(params, axes=axes)
        self.server = Packer(7, period=params.frame_s)
        self.rng = np.random.default_rng(seed)
        self.axes = axes
        self.plain = Held(params.hold, ticks=M, axes=axes)  # the same hold, alone
        self.brought = self.hand = self.sent = self.played = 0.0
        self.repeated = self.beyond = self.in_hold = 0.0
        self.x = self.draw(0.01)
        self.xd = self.draw(0.1)
        self.packet = None
        self.packets = 0  # sent

    def draw(self, scale):
        return value(tuple(self.rng.normal(0.0, scale, self.axes).tolist()))

    def frame(self, *, wave, lost, late, ticks=M, change=lambda asked, xd: asked, silent=False):
        """Send, hear (where the packet is not late), and run the ticks."""
        self.sent += energy_j(self.port.send(), M * TICK_S)
        self.packets += 1
        for _ in range(lost + 1):  # the last of these comes in
            self.server.pack(self.draw(wave), self.draw(0.02), 0)
        new = self.packet is None or not late
        brought, played = self.brought, self.played
        if new:
            echo = (max(self.packets - 2, 0), 0, 0)
            self.packet = self.server.pack(self.draw(wave), self.draw(0.02), 0, echo=echo)
            self.brought = float(np.sum(self.packet.energy)) - self.before()
        self.port.on_packet(self.packet)
        if silent:
            self.port.silence()
            self.plain.load(0.0 * self.packet.wave)
        else:
            self.port.receive(self.packet.wave)
            self.plain.load(self.packet.wave)
            if not new:
                self.repeated += energy_j(self.packet.wave, M * TICK_S)
        for _ in range(ticks):
            self.tick(change)
        more = (self.played - played) - (self.brought - brought)
        self.beyond = max(self.beyond + more, 0.0)

    def before(self):
        """What was sent to nobody, before the first packet that came."""
        if not hasattr(self, "_before"):
            own = energy_j(self.packet.wave, self.packet.period)
            self._before = float(np.sum(self.packet.energy)) - own
        return self._before

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


@pytest.mark.parametrize("kind", PAID)
@given(st.data(), dofs, seeds, st.sampled_from([0.01, 0.3, 3.0]))
def test_on_a_link_in_time_no_energy_is_made(kind, data, axes, seed, wave):
    ends = Ends(data.draw(masters(kind)), axes, seed)
    for _ in range(40):
        ends.frame(wave=wave, lost=0, late=False, ticks=int(ends.rng.integers(1, M + 1)))
        assert ends.balance >= -ends.tolerance()
    assert ends.port.energies["position_owed"] <= ends.tolerance()


@pytest.mark.parametrize("kind", PAID)
@given(
    st.data(),
    dofs,
    seeds,
    st.floats(0.0, 0.6),
    st.sampled_from([0.01, 0.3, 3.0]),
    st.booleans(),
)
def test_lossy_late_and_silent_links_leave_only_the_deficit_of_the_hold(
    kind, data, axes, seed, bad, wave, early
):
    ends = Ends(data.draw(masters(kind)), axes, seed)
    for _ in range(40):
        ends.frame(
            wave=wave,
            lost=int(ends.rng.random() < bad) * int(ends.rng.integers(1, 4)),
            late=ends.rng.random() < bad,
            silent=ends.rng.random() < 0.3 * bad,
            ticks=int(ends.rng.integers(1, M + 1)) if early else M,
        )
        ends.port.settle()
        deficit = ends.port.energies["position_owed"]
        assert ends.balance + deficit >= -ends.tolerance()
        assert deficit <= ends.largest_deficit + ends.tolerance()


@pytest.mark.parametrize("kind", PAID)
@settings(max_examples=50)  # each of 320 ticks
@given(st.data(), dofs, seeds, st.floats(0.05, 20.0), st.floats(1.0, 20000.0))
def test_limits_of_force_and_slew_leave_only_their_own_debt(kind, data, axes, seed, force, slew):
    ends = Ends(data.draw(masters(kind)), axes, seed)
    safety = ForceLimits(axes=axes, max_force=force, max_slew=slew, soft_start_s=0.02)

    def limited(asked, xd):
        return safety(asked, xd, x=xd)

    for _ in range(40):
        ends.frame(wave=0.3, lost=0, late=False, change=limited)
        assert ends.balance + ends.port.s.deficit_j >= -ends.tolerance()


@pytest.mark.parametrize("kind", PAID)
@settings(max_examples=50)
@given(st.data(), dofs, seeds, st.floats(0.1, 30.0))
def test_any_force_at_all_leaves_only_its_own_debt(kind, data, axes, seed, force):
    ends = Ends(data.draw(masters(kind)), axes, seed)
    for _ in range(40):
        ends.frame(wave=0.3, lost=0, late=False, change=lambda asked, xd: ends.draw(force))
        assert ends.balance + ends.port.s.deficit_j >= -ends.tolerance()


@pytest.mark.parametrize("gain", [5.0, 20.0, 100.0])
def test_control_the_published_feedback_makes_energy(gain):
    """An avatar that stands away and pushes: what pulls the device to it is paid by nobody."""
    made = {}
    for kind in ("printed", *PAID):
        params = MasterParams(position=PositionParams(feedback=kind, gain=gain))
        port, server = Port(params), Packer(7, period=M * TICK_S)
        x, brought, hand, sent = 0.0, 0.0, 0.0, 0.0
        for frame in range(60):
            sent += port.send() ** 2 * M * TICK_S / 2
            packet = server.pack(0.0, -0.01 if frame else 0.0, 0, echo=(frame + 1, 0, 0))
            brought = packet.energy
            port.on_packet(packet)
            port.receive(packet.wave)
            for _ in range(M):
                xd = -0.02
                f = port.step(x, xd)
                port.applied(f)
                hand += f * xd * TICK_S
                x += xd * TICK_S * (x > -0.005)
        made[kind] = sent - brought - hand
    assert made["printed"] > 1e-5
    assert max(made[kind] for kind in PAID) <= 1e-15


@given(seeds, st.sampled_from(PAID), filters, holds)
def test_never_more_than_the_cap_is_saved(seed, kind, filtering, hold):
    params = MasterParams(
        hold=hold,
        filter=filtering,
        position=PositionParams(feedback=kind, gain=1e-6, most_j=1e-3),
    )
    ends = Ends(params, 1, seed)
    for _ in range(40):
        ends.frame(wave=3.0, lost=0, late=False)
        assert 0.0 <= ends.port.energies["position_surplus"] <= 1e-3
    assert ends.port.energies["position_discarded"] > 0.0
