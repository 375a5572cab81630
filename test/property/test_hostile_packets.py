# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What both ends of the strict channel believe of a packet: no more than a legal device can have
sent in the time for which the packet stands, and that exactly.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.session_given import session_given

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import DeviceSample
from pmwvc_core.params import ContactParams, MasterParams, ServerParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import WavePacket

MS = 1_000_000
B, M, FRAME_S = 25.0, 8, 0.008
LONGEST = (20.0 + 20.0 * B) / math.sqrt(2.0 * B)  # 20 N at 20 m/s, the largest of all settings
POWER_W = 0.5 * LONGEST**2


class Master:
    """A force loop that rests, and what it counts of the packets that it is given."""

    def __init__(self):
        self.loop = UserEnd(
            User("user1", master=MasterParams(impedance=B, rate_drop=M, store_j=0.0)),
            session_given(channel="strict", server=ServerParams(period_s=FRAME_S)),
            epoch=5,
        )
        self.k, self.moved = 0, 0.0

    def run(self, frames, *packets):
        for number in range(frames * M):
            given = list(packets) if not number else []
            *_, row = self.loop.tick(self.k, self.k * MS, DeviceSample(0.0, 0.0), given)
            self.k += 1
            self.moved += row[7] * 1e-3
        return self

    @property
    def received_j(self):
        """Energy that counts as received."""
        return self.loop.report().v_rx


class Server:
    """A server with an avatar that touches nothing: it goes where the waves that count move it."""

    def __init__(self):
        nothing = ContactParams(contact_stiffness=0.0, contact_damping=0.0)
        master = MasterParams(impedance=B, rate_drop=M)
        self.step = ServerEnd(
            session_given(
                users=[User("user1", side=-1, master=master, contact=nothing)],
                channel="strict",
                server=ServerParams(period_s=FRAME_S, store_j=0.0),
                times=ServerTimes(0.03, 60.0, 0.5),
            ),
            epoch=901,
        )
        self.frame = 0

    def run(self, frames, *packets):
        for number in range(frames):
            given = list(packets) if not number else []
            _, self.row = self.step.tick(self.frame * 8 * MS, [given])
            self.frame += 1
        return self

    @property
    def moved(self):
        """Integral of the waves given out, by which the avatar went."""
        return (self.row.x_s[0] + 0.03) * math.sqrt(B / 2.0)


def packet(seq, *, integral=0.0, energy=0.0, wave=0.0, period=FRAME_S, **fields):
    sent_ns = fields.pop("sent_ns", seq * 8 * MS)
    rest = {"position": -0.03, "epoch": 11} | fields
    return WavePacket(
        seq=seq,
        sent_ns=sent_ns,
        period=period,
        wave=wave,
        integral=integral,
        energy=energy,
        **rest,
    )


@given(st.integers(0, 40), st.floats(0.0, 3.0))
def test_the_energy_of_lost_packets_counts_up_to_that_of_the_longest_legal_wave(lost, claimed):
    """After ``lost`` packets one claims a part of what may be believed, or more."""
    end = Master().run(1, packet(1)).run(1, packet(2, energy=0.25))
    assert end.received_j == 0.25
    legal_j = POWER_W * (lost + 1) * FRAME_S
    end.run(1, packet(3 + lost, energy=0.25 + claimed * legal_j))
    assert end.received_j == pytest.approx(0.25 + min(claimed, 1.0) * legal_j, rel=1e-12)


@pytest.mark.parametrize("lost", [0, 1, 7])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_jump_of_the_integral_after_lost_packets_moves_no_further_than_a_legal_wave(lost, sign):
    """It is given out in full: the energy that goes with it counts, too, and is just enough."""
    lasts_s = (lost + 1) * FRAME_S
    for end in (Master(), Server()):
        end.run(1, packet(1)).run(1, packet(2))
        wild = {"integral": sign * 1e3, "energy": 1e9}
        end.run(1, packet(3 + lost, **wild))
        for later in range(4 + lost, 50 + lost):  # nothing more than that comes
            end.run(1, packet(later, **wild))
        # the sums that go on from there are believed as far as the longest wave, packet by packet
        assert abs(end.moved) <= LONGEST * (lasts_s + 46 * FRAME_S) * (1.0 + 1e-9)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize(("lost", "wild"), [(0, 1e3), (3, 1e3), (0, -1e308)])
def test_wild_sums_of_one_packet_count_as_far_as_legal_and_the_true_ones_bring_them_back(
    lost, wild
):
    energy, sign = max(abs(wild), 1e9), math.copysign(1.0, wild)
    for end in (Master(), Server()):
        for seq in range(1, 21):
            end.run(1, packet(seq))
        end.run(1, packet(21 + lost, integral=wild, energy=energy))
        legal, most = LONGEST * (lost + 1) * FRAME_S, sign * end.moved
        for later in range(22 + lost, 150 + lost):
            end.run(1, packet(later, energy=energy))
            most = max(most, sign * end.moved)
        # at the master the ramp still rises when the true sums come
        assert most <= legal * (1.0 + 1e-9)
        assert most > 0.5 * legal or abs(wild) > 1e150  # whose square is no number
        assert end.moved == pytest.approx(0.0, abs=1e-6)


def test_a_sum_of_energy_that_falls_takes_nothing_back_and_pays_nothing_twice():
    end = Master().run(1, packet(1, energy=5.0)).run(1, packet(2, energy=5.2))
    assert end.received_j == pytest.approx(0.2, rel=1e-12)
    for seq, energy in ((3, 4.0), (4, -1e9), (5, 5.1)):
        end.run(1, packet(seq, energy=energy))
        assert end.received_j == pytest.approx(0.2, rel=1e-12)
    end.run(1, packet(6, energy=5.3))
    assert end.received_j == pytest.approx(0.3, rel=1e-12)


def test_a_wave_longer_than_any_legal_one_is_refused_and_the_longest_is_not():
    for longer, counted_j in ((1e-9, 0.0), (-1e-9, 0.01)):
        end = Master().run(1, packet(1))
        end.run(1, packet(2, wave=LONGEST * (1.0 + longer), energy=0.01))
        assert end.received_j == counted_j


@pytest.mark.parametrize(
    ("apart_s", "lasts_s"),
    [(0.02, 0.02), (0.008, 0.016), (0.0241, 0.0241), (0.1, 0.032), (-1.0, 0.016)],
)
def test_lost_packets_of_two_lengths_stand_for_what_the_senders_clock_says_within_bounds(
    apart_s, lasts_s
):
    """Packets of 4 and of 12 ms came; two were lost before one of 8 ms."""
    end = Master().run(1, packet(1, period=0.004)).run(1, packet(2, period=0.012))
    last_ns = 16 * MS
    end.run(10, packet(5, sent_ns=last_ns + round(apart_s * 1e9), energy=1e9))
    assert end.received_j == pytest.approx(POWER_W * lasts_s, rel=1e-9)


def test_numbers_far_ahead_stand_for_no_more_than_the_time_that_passed_and_ten_seconds():
    end = Master().run(1, packet(1)).run(1, packet(2))
    end.run(1, packet(40_000, energy=1e9))
    assert end.received_j == pytest.approx(POWER_W * (10.0 + FRAME_S), rel=1e-12)


def test_the_energy_before_the_first_packet_and_before_a_restart_does_not_count():
    end = Master().run(1, packet(1, energy=3.0)).run(1, packet(2, energy=3.5))
    end.run(30)  # silent, so that another sender may follow
    answer = {"epoch": 12, "echo_seq": 1}
    end.run(1, packet(1, energy=7.0, echo_sent_ns=end.k * MS, **answer))
    assert end.received_j == 0.5
    end.run(1, packet(2, energy=7.25, **answer))
    assert end.received_j == pytest.approx(0.75, rel=1e-12)
    np.testing.assert_allclose(end.moved, 0.0)
