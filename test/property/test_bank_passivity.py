# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passivity of a filter bank between a passive server and a passive local model."""

import itertools
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.filter_runs import BUTTERWORTH, Stage
from support.port_parts import Part
from support.strategies import signals

from pmwvc_core.params import BankParams, LocalModelParams, MasterParams

LOW_REACHING = {
    "high_pass_hz": 4.0,
    "high_pass_db": 3.0,
    "high_stop_hz": 0.4,
    "high_stop_db": 20.0,
}
poles_rad_s = st.floats(0.1, 2000.0)
stiffnesses = st.floats(0.0, 1e6)
dampings = st.one_of(st.just(0.0), st.floats(0.0, 1e4))
STILL = itertools.repeat(0.0)  # places of the device
reflections = st.one_of(st.sampled_from([-1.0, 1.0]), st.floats(-1.0, 1.0))


class Server:
    """Something passive behind the low branch: a delay, and a reflection that changes."""

    def __init__(self, delay, reflections):
        self._line = [0.0] * delay
        self._reflections = itertools.cycle(reflections)

    def answer(self):
        return next(self._reflections) * self._line[0]

    def take(self, u):
        self._line = [*self._line[1:], u]


def returned(bank, server, waves, places=STILL):
    """Yield the wave that comes back at every tick; the device is at ``places``."""
    for u in waves:
        w = bank.down(server.answer())
        v = w + bank.offer(next(places))(u)
        server.take(bank.step(u))
        yield v


def excess(bank, server, waves, places=STILL):
    """Return the largest sum of |v|^2 - |u|^2 so far, over |u|^2 in all."""
    kept = np.cumsum(
        [u * u - v * v for u, v in zip(waves, returned(bank, server, waves, places), strict=True)]
    )
    return -kept.min() / np.sum(np.square(waves))


def complementary(pole_rad_s, stiffness, damping, matrix="", **local):
    return MasterParams(
        impedance_matrix=matrix,
        bank=BankParams(kind="complementary", split_rad_s=pole_rad_s),
        local_model=LocalModelParams(stiffness=stiffness, damping=damping, **local),
    )


@given(
    waves=signals(longest=120),
    pole=poles_rad_s,
    stiffness=stiffnesses,
    damping=dampings,
    delay=st.integers(1, 30),
    reflections=st.lists(reflections, min_size=1, max_size=20),
    touching=st.lists(st.booleans(), min_size=1, max_size=7),
)
@settings(deadline=None)
def test_the_complementary_bank_gives_out_no_more_than_it_got_at_any_tick(
    waves, pole, stiffness, damping, delay, reflections, touching
):
    """Whatever passive server and local model: here both change as they like."""
    places = itertools.cycle([1.0 if there else -1.0 for there in touching])
    params = complementary(pole, stiffness, damping, acts="above")
    total = np.sum(np.square(waves))
    if total > 0.0:
        server = Server(delay, reflections)
        assert excess(Part(params), server, waves.tolist(), places) <= 1e-9


@given(waves=signals(longest=60, dof=3), pole=poles_rad_s, stiffness=stiffnesses)
@settings(deadline=None)
def test_the_local_model_takes_what_its_port_gets(waves, pole, stiffness):
    """Stored and dissipated are what went in, with a number and with a matrix impedance."""
    for matrix in ("", "30 2 0; 2 20 1; 0 1 25"):
        bank = Part(complementary(pole, stiffness, 2.0, matrix), axes=3)
        for _ in returned(bank, Server(1, [1.0]), waves):
            pass
        found = bank.energies
        taken = found["bank_high_in"] - found["bank_high_out"]
        kept = found["local_stored"] + found["local_dissipated"]
        assert abs(taken - kept) <= 1e-9 * (found["bank_high_in"] + 1e-12)
        assert found["local_stored"] >= 0.0


class Aliased(Server):
    """A server behind the anti-aliasing filter of the dissertation's bank."""

    def __init__(self, delay, reflections):
        super().__init__(delay, reflections)
        self._filter = Stage(BUTTERWORTH)

    def take(self, u):
        super().take(self._filter.step(u))


def test_control_a_dissertation_bank_that_reaches_down_can_give_out_more_than_it_got():
    """|LP1| + |LP2| |HP| is 1.90 at 9.4 Hz: a delay that turns the server's answer into the phase
    of the local model's finds it. With the same environment the complementary pair is passive.
    """
    waves = [math.sin(2.0 * math.pi * 9.4e-3 * k) for k in range(4000)]
    local = LocalModelParams(stiffness=0.0, damping=0.0)

    def worst(bank):
        params = MasterParams(bank=bank, local_model=local)
        return max(
            excess(Part(params), Aliased(delay, [sign]), waves)
            for delay in range(1, 60, 6)
            for sign in (-1.0, 1.0)
        )

    assert worst(BankParams(kind="dissertation", **LOW_REACHING)) > 2.0
    assert worst(BankParams(kind="complementary", split_rad_s=25.0)) <= 1e-9


def test_control_a_local_model_that_opens_and_closes_makes_table_1_active():
    """With the filters of Table 1 |LP1| + |LP2| |HP| stays within 1e-12 of 1, so no linear
    environment makes the bank active by more. A contact that opens and closes at the frequency of
    the wave turns it into a steady one, in phase with the server's.
    """
    waves = [0.7 + math.cos(2.0 * math.pi * 0.2 * k) for k in range(4000)]

    def worst(bank):
        found = []
        for shift, sign in itertools.product(range(5), (-1.0, 1.0)):
            places = itertools.cycle(sign * np.roll([1.0, 1.0, -1.0, -1.0, -1.0], shift))
            local = LocalModelParams(stiffness=0.0, damping=1e4, acts="above")
            part = Part(MasterParams(bank=bank, local_model=local))
            found.append(excess(part, Aliased(1, [1.0]), waves, places))
        return max(found)

    assert worst(BankParams(kind="dissertation")) > 0.2
    assert worst(BankParams(kind="complementary", split_rad_s=100.0)) <= 1e-9
