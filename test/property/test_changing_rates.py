# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rates that change in a session, and packets left out by a deadband: on the strict channel no
energy and no displacement is lost or made. The plain receiver under the same is the control.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.packer import Packer
from support.receiving import ReceivingEnd, SendingEnd
from support.simulated import least_j

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_bringup import scenarios as files
from pmwvc_core.law.channel.playout import waiting
from pmwvc_core.law.server_step import ABSENT
from pmwvc_core.numeric import squared
from pmwvc_core.simulation.session import SteppedSession

LEAST_J = -1e-12
DURATION_S = 1.6
WEBER = ("master.deadband.kind=weber", "server.deadband.kind=weber")

RATES = ("user1.master.rate_drop", "user2.master.rate_drop", "server.period_s")
changes = st.lists(
    st.tuples(
        st.integers(0, 1599).map(lambda ms: ms * 1e-3), st.sampled_from(RATES), st.integers(1, 40)
    ),
    min_size=1,
    max_size=8,
)
networks = st.sampled_from(
    (
        (),
        ("link.loss=0.1",),
        ("link.jitter=uniform", "link.jitter_s=0.012"),
        ("link.duplicate=0.3",),
    )
)


def ran(texts, found=()):
    """Run hands that grip at once, with rates changed at those times."""
    each = [
        f"{time_s:.4f} {name}={value * 0.001 if 'period' in name else value:g}"
        for time_s, name, value in found
    ]
    own = [
        "channel=strict",
        "task.grip_s=0.05",
        "task.grip_rise_s=0.1",
        "safety.soft_start_s=0.05",
    ]
    texts = [*own, *texts, f"changes={'; '.join(each)}"]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=DURATION_S)
    batch = SteppedSession(scenario)
    joined = note_joins(batch.server)
    batch.run(lambda _: None)
    return batch, batch.traces(), scenario, joined


def note_joins(step):
    """Return what will hold, per user, the integrals of the packets with which it joins."""
    found, stepped = [[] for _ in step.inboxes], step._step

    def noting(s, now_ns, packets, missed_s, p):
        for user, (guest, taken) in enumerate(zip(s.guests, packets, strict=True)):
            there = guest.presence != ABSENT
            for packet in taken:
                if packet.fresh or not there:
                    found[user].append(packet.integral[0])
                there = True
        return stepped(s, now_ns, packets, missed_s, p)

    step._step = noting
    return found


@settings(max_examples=6)  # each a session
@given(found=changes, network=networks, weber=st.booleans())
def test_no_energy_and_no_displacement_comes_or_goes_when_rates_change(found, network, weber):
    batch, traces, scenario, joined = ran([*network, *(WEBER if weber else ())], found)
    server = traces.server
    for i, energy in enumerate(user_energies(traces, scenario)):
        assert least_j(energy) >= LEAST_J
        inbox, out = batch.server.inboxes[i], np.sum(server.u_s[i][:, 0] * server.periods_s)
        playout = batch.server.s.guests[i].arrivals.playout
        assert len(joined[i]) == 1  # nobody was taken for gone
        arrived = inbox.newest.integral - joined[i][0]
        assert arrived == pytest.approx(out + waiting(playout)[0], abs=1e-12)
        # From the device's motion to the packets: U + V = sqrt(2b) x.
        user, loop = traces.users[i], batch.users[i].loop
        sent = loop.s.packing.integral[0] + loop.s.port.integral[0]
        moved = user.x_m[-1, 0] - user.x_m[0, 0]  # its last tick is not over
        waves = sent + np.sum(user.v_m[:-1, 0]) * user.tick_s
        assert waves == pytest.approx(
            np.sqrt(2.0 * scenario.users[i].impedance) * moved, abs=1e-12
        )
        assert inbox.lost == 0 or "link.loss=0.1" in network  # what is left out is not lost
    assert budget(traces, scenario).closes


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_the_plain_receiver_makes_energy_when_the_rate_changes(channel):
    """The control: it refuses packets that stand for another time than its own."""
    rng, now_ns, given, least = np.random.default_rng(4), 0, 0.0, 0.0
    receiver = ReceivingEnd(channel, period_s=0.008, timeout_s=0.03)
    packer = Packer(1, period=0.008)
    for k in range(60):
        packer.period = 0.004 if 20 <= k < 40 else 0.008
        receiver.push(packer.pack(float(rng.normal()), 0.0, now_ns), now_ns)
        if now_ns % 8_000_000 == 0:
            given += squared(receiver.step(0.008)) * 0.004
            least = min(least, packer.energy - given)
        now_ns += round(packer.period * 1e9)
    assert (least < -1e-4) == (channel == "plain")


smooth = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "dof": st.integers(1, 6),
        "ratio": st.floats(0.01, 0.5),
        "longest_s": st.sampled_from((0.01, 0.016, 0.024)),
        "roughness": st.sampled_from((0.001, 0.03, 1.0)),
        "loss": st.sampled_from((0.0, 0.2)),
    }
)


@settings(max_examples=20)
@given(of=smooth)
def test_a_deadband_costs_neither_energy_nor_displacement(of):
    rng, dof = np.random.default_rng(of["seed"]), of["dof"]
    weber = {"kind": "weber", "ratio": of["ratio"], "longest_s": of["longest_s"]}
    sender = SendingEnd(dof, period_s=0.008, **weber)
    receiver = ReceivingEnd("strict", dof, period_s=0.008, timeout_s=0.03, longest=1e3)
    inbox = receiver.inbox
    wave = rng.normal(size=dof) if dof > 1 else float(rng.normal())
    whole = paid = given = out = 0.0 * wave
    before, sent_s = None, 0.0
    for k in range(150):
        now_ns = k * 8_000_000
        wave = wave + of["roughness"] * (rng.normal(size=dof) if dof > 1 else float(rng.normal()))
        whole, paid = whole + wave * 0.008, paid + squared(wave) * 0.004
        packet = sender.send(wave, now_ns)
        if packet is not None:
            sent_s += packet.period
            assert packet.period <= max(of["longest_s"], 0.008) + 1e-12
            assert np.allclose(packet.integral, whole, rtol=1e-12, atol=1e-12)
            if rng.random() >= of["loss"]:
                receiver.push(packet, now_ns)
            if before is None and inbox.newest is not None:
                before = packet.integral - packet.wave * packet.period
        if inbox.newest is not None and not of["loss"]:
            assert not inbox.silent(now_ns)
        played = receiver.step(0.008)
        given, out = given + squared(played) * 0.004, out + played * 0.008
        assert np.all(given <= paid * (1.0 + 1e-12))
    assert sent_s + sender.s.held_s == pytest.approx(150 * 0.008)
    assert of["loss"] or inbox.lost == 0
    left = inbox.newest.integral - before - out - receiver.waiting
    assert np.all(np.abs(left) <= 1e-12 * 150)


def test_what_is_felt_is_sent_and_what_is_not_felt_is_not():
    sender = SendingEnd(period_s=0.004, kind="weber")
    assert sender.send(1.0) is not None
    assert sender.send(1.09) is None
    assert sender.send(0.91) is None
    packet = sender.send(1.11)  # beyond a tenth of the wave sent last
    assert (packet.seq, packet.period) == (2, pytest.approx(0.012))
    assert packet.wave == pytest.approx((1.09 + 0.91 + 1.11) / 3)
    held = 0
    while sender.send(packet.wave) is None:
        held += 1
    assert held == 5  # the sixth frame makes 24 ms, the longest time
    assert sender.send(packet.wave) is None
    assert sender.send(packet.wave, anew=True) is not None  # a flag does not wait
    every = SendingEnd(period_s=0.008)  # the control
    assert [every.send(1.0).period for _ in range(5)] == [0.008] * 5
