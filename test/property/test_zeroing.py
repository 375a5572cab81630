# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The zeroing channel gives out no more energy than its packets carried, whatever the network
does, and loses the motion of those that do not come in time. Holding the last wave is the control.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.packer import Packer
from support.receiving import ReceivingEnd
from support.simulated import judged, simulated

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.outcomes import outcomes
from pmwvc_bringup import scenarios as files
from pmwvc_core.errors import ScenarioError
from pmwvc_core.numeric import squared

PERIOD_S = 0.008
ROUNDING = 1e-12


def receiver(dof, *, once):
    channel = "zeroing" if once else "plain"
    return ReceivingEnd(channel, dof, period_s=PERIOD_S, timeout_s=10.0)


def balances(once, dof, seed, delays, copies):
    """Return the energy of the packets that came, less that of the waves given out, step by step
    [W s]; ``delays`` in steps, None: lost.
    """
    rng = np.random.default_rng(seed)
    packer, end = Packer(1, period=PERIOD_S), receiver(dof, once=once)
    due = {}
    for step, (delay, twice) in enumerate(zip(delays, copies, strict=True)):
        packet = packer.pack(rng.normal(size=dof) if dof > 1 else rng.normal(), 0.0, step + 1)
        if delay is not None:
            due.setdefault(step + delay, []).append(packet)
        if delay is not None and twice:
            due.setdefault(step + delay + 1, []).append(packet)
    balance, found = 0.0, []
    for step in range(len(delays) + 12):
        for packet in due.get(step, []):
            if end.push(packet, step + 1) is not None:
                balance += float(np.sum(squared(packet.wave))) * PERIOD_S / 2.0
        balance -= float(np.sum(squared(end.step(PERIOD_S)))) * PERIOD_S / 2.0
        found.append(balance)
    return np.array(found)


fates = st.lists(st.sampled_from((0, 0, 1, 2, 5, None)), min_size=1, max_size=40)


@given(dof=st.integers(1, 6), seed=st.integers(0, 2**32 - 1), delays=fates, data=st.data())
def test_no_more_energy_is_given_out_than_came(dof, seed, delays, data):
    copies = data.draw(st.lists(st.booleans(), min_size=len(delays), max_size=len(delays)))
    assert balances(True, dof, seed, delays, copies).min() >= -ROUNDING


@pytest.mark.parametrize("delays", [(0, None), (0, 2), (0, 0, None, None, 0)])
def test_holding_the_last_wave_gives_out_energy_that_never_came(delays):
    copies = [False] * len(delays)
    assert balances(False, 1, 1, delays, copies).min() < -1e-3
    assert balances(True, 1, 1, delays, copies).min() >= -ROUNDING


def ran(channel, *settings, duration_s=8.0):
    texts = [f"channel={channel}", *settings]
    return files.load("carry_16ms", settings_texts=texts, duration_s=duration_s)


def apart_m(traces):
    """Distances of devices and avatars at the end [m]."""
    return [
        abs(float(user.x_m[-1, 0] - x_s[-1, 0]))
        for user, x_s in zip(traces.users, traces.server.x_s, strict=True)
    ]


def test_a_session_loses_motion_and_not_energy_where_packets_come_unevenly():
    least, apart = {}, {}
    for channel in ("zeroing", "plain"):
        scenario = ran(channel, "link.preset=wifi_bad")
        traces = simulated(scenario)
        ways = [way for e in user_energies(traces, scenario) for way in (e.up, e.down)]
        least[channel] = min(way.minimum_j for way in ways)
        apart[channel] = max(apart_m(traces))
        assert budget(traces, scenario).closes
        assert inconsistencies(traces, scenario) == []
    assert least["zeroing"] >= -1e-12
    assert least["plain"] < -1e-7
    assert apart["zeroing"] > 1e-2
    uneven = ran("zeroing", "link.preset=wifi_bad")
    offsets = [each for each in outcomes(uneven, judged(uneven)) if each.what == "offset"]
    assert offsets
    assert all(each.hit is None and "how late packets come" in each.text for each in offsets)


def test_where_every_packet_comes_in_time_it_is_the_plain_channel():
    both = (ran(channel, duration_s=4.0) for channel in ("zeroing", "plain"))
    one, other = map(simulated, both)
    for mine, theirs in zip(one.users, other.users, strict=True):
        for name in ("x_m", "f_applied", "v_m"):
            assert np.array_equal(getattr(mine, name), getattr(theirs, name))


def test_a_step_that_is_no_packet_interval_is_refused():
    with pytest.raises(
        ScenarioError, match=r"server.period_s = 0.004: must be the packet interval"
    ):
        ran("zeroing", "server.period_s=0.004")
    assert not dataclasses.replace(ran("plain"), controller="direct", channel="zeroing").zeroing
