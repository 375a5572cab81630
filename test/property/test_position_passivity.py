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

from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.numeric import dot, squared
from pmwvc_core.params import FilterParams, MasterParams, PositionParams, SafetyParams
from pmwvc_core.transport.packet import Packer
from pmwvc_core.wave.rates import Hold

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
shapes = st.sampled_from(["float", (1,), (6,), (3, 2)])
gains = st.floats(0.1, 200.0)
filters = st.sampled_from(FILTERS)
holds = st.sampled_from(["zoh", "foh"])
impedances = st.floats(0.5, 200.0)


def masters(kind):
    """Draw the parameters of masters with a feedback, and signals of some shape."""
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


class Ends:
    """A master between an invented server and an invented hand, and the account of its ends."""

    def __init__(self, params, shape, seed):
        self.port = WaveMaster(params)
        self.server = Packer(7, period=params.frame_s)
        self.rng = np.random.default_rng(seed)
        self.shape = None if shape == "float" else shape
        self.plain = Hold(params.hold, ticks=M)  # the same hold, alone
        self.brought = self.hand = self.sent = self.played = 0.0
        self.repeated = self.beyond = self.in_hold = 0.0
        self.x = self.draw(0.01)
        self.xd = self.draw(0.1)
        self.packet = None
        self.packets = 0  # sent

    def draw(self, scale):
        value = self.rng.normal(0.0, scale, self.shape)
        return float(value) if self.shape is None else value

    def frame(self, *, wave, lost, late, ticks=M, change=lambda asked, xd: asked, silent=False):
        """Send, hear (where the packet is not late), and run the ticks."""
        self.sent = self.sent + squared(self.port.send()) * (M * TICK_S / 2)
        self.packets += 1
        for _ in range(lost + 1):  # the last of these comes in
            self.server.pack(self.draw(wave), self.draw(0.02), 0)
        new = self.packet is None or not late
        brought, played = self.brought, self.played
        if new:
            echo = (max(self.packets - 2, 0), 0, 0)
            self.packet = self.server.pack(self.draw(wave), self.draw(0.02), 0, echo=echo)
            self.brought = self.packet.energy - self.before()
        self.port.on_packet(self.packet)
        if silent:
            self.port.silence()
            self.plain.load(0.0 * self.packet.wave)
        else:
            self.port.receive(self.packet.wave)
            self.plain.load(self.packet.wave)
            if not new:
                self.repeated = self.repeated + squared(self.packet.wave) * (M * TICK_S / 2)
        for _ in range(ticks):
            self.tick(change)
        more = (self.played - played) - (self.brought - brought)
        self.beyond = np.maximum(self.beyond + more, 0.0)

    def before(self):
        """What was sent to nobody, before the first packet that came."""
        if not hasattr(self, "_before"):
            own = squared(self.packet.wave) * (self.packet.period / 2)
            self._before = self.packet.energy - own
        return self._before

    def tick(self, change):
        self.xd = 0.97 * self.xd + self.draw(0.05)
        f = change(self.port.step(self.x, self.xd), self.xd)
        self.port.applied(f)
        self.hand = self.hand + dot(f, self.xd) * TICK_S
        self.x = self.x + self.xd * TICK_S
        v = self.plain.step()
        self.played = self.played + squared(v) * (TICK_S / 2)
        self.in_hold = squared(v) * (TICK_S * (self.plain.ticks - 1) / 4)  # at most

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
        return np.minimum(self.repeated, self.beyond + self.in_hold)

    def tolerance(self):
        return 1e-11 * (1.0 + np.max(self.brought) + np.max(self.sent) + np.max(abs(self.hand)))


@pytest.mark.parametrize("kind", PAID)
@given(st.data(), shapes, seeds, st.sampled_from([0.01, 0.3, 3.0]))
def test_on_a_link_in_time_no_energy_is_made(kind, data, shape, seed, wave):
    ends = Ends(data.draw(masters(kind)), shape, seed)
    for _ in range(40):
        ends.frame(wave=wave, lost=0, late=False, ticks=int(ends.rng.integers(1, M + 1)))
        assert np.all(ends.balance >= -ends.tolerance())
    assert np.all(ends.port.accounts["position_owed"] <= ends.tolerance())


@pytest.mark.parametrize("kind", PAID)
@given(
    st.data(), shapes, seeds, st.floats(0.0, 0.6), st.sampled_from([0.01, 0.3, 3.0]), st.booleans()
)
def test_lossy_late_and_silent_links_leave_only_the_deficit_of_the_hold(
    kind, data, shape, seed, bad, wave, early
):
    ends = Ends(data.draw(masters(kind)), shape, seed)
    for _ in range(40):
        ends.frame(
            wave=wave,
            lost=int(ends.rng.random() < bad) * int(ends.rng.integers(1, 4)),
            late=ends.rng.random() < bad,
            silent=ends.rng.random() < 0.3 * bad,
            ticks=int(ends.rng.integers(1, M + 1)) if early else M,
        )
        ends.port.on_packet(ends.packet)  # settles the frame
        deficit = ends.port.accounts["position_owed"]
        assert np.all(ends.balance + deficit >= -ends.tolerance())
        assert np.all(deficit <= ends.largest_deficit + ends.tolerance())


@pytest.mark.parametrize("kind", PAID)
@settings(max_examples=50)  # each of 320 ticks
@given(st.data(), shapes, seeds, st.floats(0.05, 20.0), st.floats(1.0, 20000.0))
def test_limits_of_force_and_slew_leave_only_their_own_debt(kind, data, shape, seed, force, slew):
    ends = Ends(data.draw(masters(kind)), shape, seed)
    safety = SafetyLimiter(
        SafetyParams(max_force=force, max_slew=slew, soft_start_s=0.02),
        tick_s=TICK_S,
        packet_s=M * TICK_S,
    )

    def limited(asked, xd):
        return safety.step(asked, xd, xd, silence_s=0.0, coupled=True)

    for _ in range(40):
        ends.frame(wave=0.3, lost=0, late=False, change=limited)
        assert np.all(ends.balance + ends.port.deficit_j >= -ends.tolerance())


@pytest.mark.parametrize("kind", PAID)
@settings(max_examples=50)
@given(st.data(), shapes, seeds, st.floats(0.1, 30.0))
def test_any_force_at_all_leaves_only_its_own_debt(kind, data, shape, seed, force):
    ends = Ends(data.draw(masters(kind)), shape, seed)
    for _ in range(40):
        ends.frame(wave=0.3, lost=0, late=False, change=lambda asked, xd: ends.draw(force))
        assert np.all(ends.balance + ends.port.deficit_j >= -ends.tolerance())


@pytest.mark.parametrize("gain", [5.0, 20.0, 100.0])
def test_control_the_published_feedback_makes_energy(gain):
    """An avatar that stands away and pushes: what pulls the device to it is paid by nobody."""
    made = {}
    for kind in ("printed", *PAID):
        params = MasterParams(position=PositionParams(feedback=kind, gain=gain))
        port, server = WaveMaster(params), Packer(7, period=M * TICK_S)
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
    ends = Ends(params, "float", seed)
    for _ in range(40):
        ends.frame(wave=3.0, lost=0, late=False)
        assert 0.0 <= ends.port.accounts["position_surplus"] <= 1e-3
    assert ends.port.accounts["position_discarded"] > 0.0
