# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers without waves in small cases with answers by hand."""

import numpy as np
import pytest
from support.baseline_link import FRAME_S, TICK_S, BaselineLink, M
from support.law_rigs import Users
from support.packer import Packer
from support.port_rig import Port

from pmwvc_core.law.without_waves.pspm import ModulatedSpring, Pspm, aimed, set_to
from pmwvc_core.params import BaselineParams, ContactParams, MasterParams, ServerParams
from pmwvc_core.params.server import TdpaParams, VirtualCouplingParams

BASELINES = ("direct", "virtual_coupling", "tdpa", "pspm")


def packet(energy, *, epoch=1, seq=1, wave=0.0):
    packer = Packer(epoch, period=FRAME_S)
    packer.seq = seq - 1
    return packer.pack(wave, 0.0, 0, energy=energy)


def server_of(controller, *, users=1, environment="wall", baseline=None, **contact):
    contacts = [ContactParams(contact="bilateral", **contact)] * users
    server = ServerParams(environment=environment)
    return Users(server, contacts, controller=controller, baseline=baseline)


def master_of(controller, **baseline):
    return Port(MasterParams(), controller=controller, baseline=BaselineParams(**baseline))


def still(controller, **rest):
    """A link whose device has been moved by 1 mm along axis 0 and held there for a second."""
    link = BaselineLink(controller, delay_frames=2, **rest)
    zero = link.x
    moving = zero + 0.001 / (5 * FRAME_S) * np.eye(max(1, np.size(zero)))[0]
    moving = float(moving[0]) if np.ndim(zero) == 0 else moving
    for velocity, frames in ((zero, 5), (moving, 5), (zero, 120)):
        for _ in range(frames):
            link.frame([velocity] * M)
    return link


@pytest.mark.parametrize(
    ("packets", "taken"),  # energy, epoch and number of each; what its sum has grown
    [
        ([(0.5, 1, 1), (0.7, 1, 2), (0.7, 1, 3), (1.0, 1, 4)], [0.0, 0.2, 0.0, 0.3]),
        ([(0.5, 1, 1), (9.0, 2, 1), (9.5, 2, 2)], [0.0, 0.0, 0.5]),  # another life
        ([(0.5, 1, 1), (0.2, 1, 2), (0.6, 1, 3)], [0.0, 0.0, 0.1]),  # takes nothing back
    ],
)
def test_what_arrives_is_what_a_sum_has_grown(packets, taken):
    port, sums = master_of("tdpa"), [0.0]
    for energy, epoch, seq in packets:
        port.on_packet(packet(energy, epoch=epoch, seq=seq))
        sums.append(port.arrivals.received_j)
    assert np.diff(sums) == pytest.approx(taken)


class TestVirtualCoupling:
    def test_the_avatar_solves_spring_damper_and_contact_together(self):
        """f = K_c (x - h xd) + B_c (xd_m - xd) = K h xd, by hand."""
        params = VirtualCouplingParams(stiffness=300.0, damping=3.0)
        server = server_of(
            "virtual_coupling",
            baseline=BaselineParams(virtual_coupling=params),
            contact_stiffness=500.0,
            contact_damping=0.0,
        )
        server.join(0, 0.1)
        answer = server.step([(0.101, 0.2)])
        xd = (300.0 * 0.001 + 3.0 * 0.2) / (300.0 * FRAME_S + 3.0 + 500.0 * FRAME_S)
        assert server.xd_s[0] == pytest.approx(xd)
        assert server.f_s[0] == pytest.approx(500.0 * FRAME_S * xd)
        assert answer[0] == pytest.approx(0.1 + FRAME_S * xd)


class TestTimeDomainPassivity:
    def test_the_damper_takes_what_the_force_would_give_unpaid(self):
        """Pushing 2 N at 0.5 m/s without credit: the damper cancels it."""
        params = TdpaParams(damping=0.0, damping_max=100.0, fade_s=0.0)
        master = master_of("tdpa", tdpa=params)
        master.receive(-2.0)
        assert master.step(0.0, 0.5) == pytest.approx(0.0)
        master.applied(0.0)
        master.measure(0.5 * TICK_S, 0.5)
        assert master.energies["tdpa_dissipated"] == pytest.approx(2.0 * 0.5 * TICK_S)
        assert master.energies["tdpa_allowance"] == pytest.approx(0.0)
        assert master.step(0.5 * TICK_S, 0.01) == pytest.approx(
            -2.0 + 100.0 * 0.01
        )  # at its limit

    def test_an_avatar_without_credit_stands_still_and_makes_up_for_it_later(self):
        server = server_of(
            "tdpa",
            contact_stiffness=500.0,
            contact_damping=0.0,
            baseline=BaselineParams(tdpa=TdpaParams(drift_share=0.5)),
        )
        server.join(0, 0.0)
        server.on_packet(0, packet(0.0))
        for seq in (2, 3):
            server.step([(0.002, 0.0)])
            server.on_packet(0, packet(0.0, seq=seq))
        there = server.x_s[0]
        assert there == pytest.approx(0.001)  # the first way met no force yet
        server.step([(0.002, 0.0)])
        assert server.x_s[0] == pytest.approx(there)
        assert server.f_s[0] == pytest.approx(500.0 * there)
        server.on_packet(0, packet(1.0, seq=9))
        for _ in range(20):
            server.step([(0.002, 0.0)])
        assert server.x_s[0] == pytest.approx(0.002, rel=1e-3)


LAW = Pspm(stiffness=500.0, damping=5.0, cap_j=0.02)


class TestSetPointModulation:
    def test_the_set_point_goes_as_far_as_the_tank_pays(self):
        """K/2 q^2 = 0.01 J with K = 500: q = 6.32 mm, of the 10 mm wanted."""
        spring = aimed(ModulatedSpring((0.0,), 0.01), (0.01,), (0.0,), LAW)
        assert spring.q[0] == pytest.approx(np.sqrt(2 * 0.01 / 500.0))
        assert spring.tank_j == pytest.approx(0.0, abs=1e-15)
        assert spring.spring_j == pytest.approx(0.01)

    def test_an_overdrawn_tank_moves_only_where_that_pays_back(self):
        spring = set_to(ModulatedSpring((0.0,), 0.0), (0.0,), (0.01,), -0.1, LAW)
        away = aimed(spring, (-0.01,), (0.01,), LAW)
        assert away.q == (0.0,) and away.tank_j == spring.tank_j
        beyond = aimed(spring, (0.02,), (0.01,), LAW)
        assert beyond.q[0] == pytest.approx(0.01) and beyond.tank_j > spring.tank_j


@pytest.mark.parametrize("controller", BASELINES)
class TestEveryOne:
    def test_silence_lets_go_and_leaving_takes_the_avatar_out(self, controller):
        link = still(controller)
        link.master.silence()
        assert link.master.step(link.x, 0.0) == 0.0
        link.server.leave(0)
        assert link.server.step([(0.0, 0.0)]) == [0.0]
        assert link.server.f_s == [0.0] and link.server.energies["potential"] == 0.0

    def test_who_comes_back_begins_without_a_force(self, controller):
        link = still(controller)
        link.server.leave(0)
        link.server.join(0, 0.05)
        link.server.step([(0.05, 0.0)])
        assert link.server.f_s[0] == pytest.approx(0.0, abs=1e-12)

    def test_who_is_not_there_gets_nothing_and_pushes_nothing(self, controller):
        server = server_of(controller, users=2, environment="cube")
        server.join(0, 0.0)
        for n in range(20):
            server.on_packet(0, packet(float(n), seq=n + 1))
            answers = server.step([(0.005, 0.0), (9.0, 9.0)])
        assert answers[1] == 0.0
        assert 0.0 < server.x_o < 0.02 and server.f_s[1] == 0.0

    def test_values_that_are_no_numbers_count_as_the_last_ones(self, controller):
        link = still(controller)
        master = link.master
        before = master.x
        assert np.isfinite(master.step(np.nan, np.inf))
        assert (master.x, master.send()) == (before, 0.0)
