# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The strict channel gives out no more energy than arrived, at no instant, and loses no motion,
whatever the network does. The plain channel under the same schedules is the control.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.packer import Packer
from support.receiving import Playing, ReceivingEnd

from pmwvc_core.numeric import squared

ROUNDING = 1e-12  # relative to the energy that arrived
TIMEOUT_S = 0.03
STEP_S = 0.004
PERIOD_S = 0.008

# What happens to each packet, and how many steps of the receiver follow it.
fates = st.sampled_from(("come", "come", "come", "lost", "late", "twice", "held back"))
schedules = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "dof": st.integers(1, 6),
        "amplitude": st.sampled_from((1e-3, 1.0, 1e3)),
        "fates": st.lists(fates, min_size=1, max_size=40),
        "steps": st.lists(st.sampled_from((0, 1, 2, 2, 2, 3, 10, 90)), min_size=1, max_size=8),
        "ticks": st.lists(st.sampled_from((1, 2, 8, 20)), min_size=1, max_size=6),
        "restarts": st.booleans(),
        "underpaid": st.booleans(),
        "store_j": st.sampled_from((0.0, 2e-3, 1.0)),
    }
)


def receiver(dof=1, *, channel="strict", **own):
    return ReceivingEnd(channel, dof, period_s=PERIOD_S, timeout_s=TIMEOUT_S, **own)


class Direction:
    """One direction under a schedule: a sender, a network that does its worst, a receiver."""

    def __init__(self, schedule, receiver):
        self.of, self.receiver = schedule, receiver
        self.rng = np.random.default_rng(schedule["seed"])
        self.packer = Packer(1, period=PERIOD_S)
        self.paid = self.given = self.out = self.moved = self.paid_before = 0.0
        self.before_first = None  # integral before the first packet that came
        self.least, self.held_back, self.now_ns = np.inf, [], 0

    def run(self, packets=24):
        for k in range(packets):
            if self.of["restarts"] and k == packets // 2:
                self.packer, self.paid_before = Packer(2, period=PERIOD_S), self.paid
                self.step(100)
            for packet in self.network(k):
                if self.before_first is None:
                    self.before_first = packet.integral - packet.wave * packet.period
                self.receiver.push(packet, self.now_ns)
            self.step(of(self.of["steps"], k))
        return self

    def network(self, k):
        """Send one packet; return what arrives."""
        period_s = self.packer.period = 0.001 * of(self.of["ticks"], k)
        wave = self.of["amplitude"] * self.rng.normal(size=self.of["dof"])
        wave = float(wave[0]) if self.of["dof"] == 1 else wave
        share = self.rng.random() if self.of["underpaid"] else 1.0
        self.paid = self.paid + share * squared(wave) * 0.5 * period_s
        self.moved += float(np.sum(squared(wave))) * 0.5 * period_s
        packet = self.pack(wave)
        fate, late = of(self.of["fates"], k), self.held_back
        self.held_back = {"late": [packet], "held back": [*late, packet]}.get(fate, [])
        if fate == "held back":
            return []
        return {"come": [packet, *late], "twice": [packet, *late, packet]}.get(fate, late)

    def pack(self, wave):
        paid = self.paid - self.paid_before  # of this life of the sender
        return self.packer.pack(wave, 0.0 * wave, self.now_ns, energy=paid)

    def step(self, count):
        for _ in range(count):
            wave = self.receiver.step(STEP_S)
            assert np.all(np.isfinite(wave))
            self.given = self.given + squared(wave) * 0.5 * STEP_S
            self.out = self.out + wave * STEP_S
            self.now_ns += round(STEP_S * 1e9)
            self.least = min(self.least, float(np.min(self.paid - self.given)))


def of(values, k):
    return values[k % len(values)]


@settings(max_examples=25)
@given(schedule=schedules)
def test_energy_given_out_never_exceeds_what_was_paid_and_no_displacement_is_lost(schedule):
    """All of it is given out, waiting or undelivered."""
    stored_j = schedule["store_j"]  # once a session, however often it is lent
    one = Direction(schedule, receiver(schedule["dof"], store_j=stored_j)).run()
    assert one.least >= -stored_j - ROUNDING * one.moved
    moved, newest = one.receiver.moved, one.receiver.inbox.newest
    assert moved.given_j <= stored_j + moved.received_j * (1.0 + ROUNDING)
    assert np.all(moved.received_j <= one.paid * (1.0 + ROUNDING))
    if newest is not None and not schedule["restarts"]:
        missing = newest.integral - one.before_first - one.out - one.receiver.waiting
        assert np.all(np.abs(missing) <= 1e-11 * schedule["amplitude"] * 40 * 0.02)


@settings(max_examples=20)
@given(schedule=schedules)
def test_once_packets_come_evenly_everything_paid_for_is_given_out(schedule):
    end = receiver(schedule["dof"], most_repaid=max(1.0, schedule["amplitude"]))
    one = Direction({**schedule, "underpaid": False, "restarts": False}, end).run()
    before = float(np.max(np.abs(end.waiting)))
    one.packer.period = 8 * STEP_S

    def is_settled():
        spent = end.free_j < 1e-9 * one.moved + 1e-12
        rest = float(np.max(np.abs(end.waiting))) <= 1e-2 * before + 1e-12
        return spent or (rest and end.playout.pace.store_s < 0.1)

    for _ in range(1000):
        end.push(one.pack(0.0 * one.out), one.now_ns)
        one.step(8)
        if is_settled():  # and stays so: the waves that come are zero
            break
    assert is_settled()


@pytest.mark.parametrize("fate", ["lost", "late"])
def test_the_plain_channel_gives_out_energy_that_never_came(fate):
    """The control: the newest wave held until the next one, under two of the schedules."""
    schedule = {"seed": 3, "dof": 1, "amplitude": 1.0, "restarts": False, "underpaid": False}
    schedule |= {"fates": ["come", "come", fate], "steps": [2, 3], "ticks": [8]}
    assert Direction(schedule, receiver(channel="plain")).run().least < -1e-3
    one = Direction(schedule, receiver()).run()
    assert one.least >= -ROUNDING * one.moved


def test_beginning_anew_forgives_no_debt():
    playout = Playing()
    playout.add(0.01, 0.02, PERIOD_S)
    playout.give(0.03)  # 10 mJ were lent
    playout.begin()
    playout.add(0.01, 0.01, PERIOD_S)
    assert playout.step(PERIOD_S) == 0.0
    playout.add(0.01, 0.01, PERIOD_S)
    for _ in range(4):
        playout.step(PERIOD_S)
    assert playout.given_j + playout.released_j <= playout.received_j + 1e-12
