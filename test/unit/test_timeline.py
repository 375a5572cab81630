# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The timeline of a link: settings, networks, ramps and outages at given times."""

from dataclasses import replace

import pytest
from support.plain import load

from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.distributions import DISTRIBUTIONS
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams

MS, S = 1_000_000, 1_000_000_000


def link(schedule, *, direction=0, **settings):
    params = LinkParams(schedule=schedule, keep_order=False, **settings)
    return Link(params, seed=1, direction=direction)


def delays_ms(channel, times_s, start_ns=7 * S):
    found = []
    for time_s in times_s:
        fate = channel.send(None, start_ns + round(time_s * S))[0]
        lost = fate.kind is FateKind.LOST
        found.append(fate.cause if lost else (fate.time_due_ns - fate.time_in_ns) / MS)
    return found


def test_settings_hold_from_their_time_to_the_next_entry():
    channel = link("1 delay_s=0.05; 2 outage; 3 base", delay_s=0.01)
    times = (0.0, 0.999, 1.0, 1.999, 2.0, 2.999, 3.0, 9.0)
    out = Cause.OUTAGE
    assert delays_ms(channel, times) == [10.0, 10.0, 50.0, 50.0, out, out, 10.0, 10.0]


def test_an_entry_names_what_differs_from_the_link_and_not_from_the_entry_before():
    channel = link("1 delay_s=0.05; 2 loss=1", delay_s=0.01)
    assert delays_ms(channel, (0.0, 1.5, 2.5)) == [10.0, 50.0, Cause.LOSS]
    channel = link("1 loss=1; 2 delay_s=0.05")
    assert delays_ms(channel, (0.0, 1.5, 2.5)) == [0.0, Cause.LOSS, 50.0]


def test_a_ramp_goes_straight_to_the_next_entry_and_a_timeline_may_begin_anew():
    channel = link("0 delay_s=0.02..0.1; 4 delay_s=0.1..0.02; 8 repeat")
    found = delays_ms(channel, (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 9.0))
    assert found == pytest.approx([20.0, 40.0, 60.0, 100.0, 60.0, 20.0, 40.0])


@pytest.mark.parametrize("direction, way", [(0, "up"), (1, "down")])
def test_a_network_by_name_has_the_settings_of_the_direction(direction, way):
    channel = link("1 lte jitter=none slot_max_s=0 slot_min_s=0", direction=direction)
    wanted = getattr(PRESETS["lte"], way).delay_s * 1e3
    assert delays_ms(channel, (0.0, 1.0)) == [0.0, pytest.approx(wanted)]


def test_random_numbers_go_on_through_a_timeline():
    plain = Link(LinkParams(loss=0.3, keep_order=False), seed=1)
    other = link("0.02 delay_s=0.5; 0.05 base", loss=0.3)
    kinds = [[each.send(n, n * MS)[0].kind for n in range(100)] for each in (plain, other)]
    assert kinds[0] == kinds[1]


def test_new_settings_keep_the_clock_of_the_timeline():
    channel = link("5 outage", delay_s=0.01)
    assert delays_ms(channel, (0.0, 4.0)) == [10.0, 10.0]
    channel.configure(LinkParams(schedule="5 outage", delay_s=0.02, keep_order=False))
    assert delays_ms(channel, (4.5, 5.5)) == [20.0, Cause.OUTAGE]


@pytest.mark.parametrize(
    "schedule, text",
    [
        ("3 outage; 2 base", r"entry 2 '2 base': time = 2: must be 3..1e\+06 s"),
        ("-1 outage", r"entry 1 '-1 outage': time = -1: must be 0"),
        ("soon outage", r"time = soon: must be 0"),
        ("3", r"entry 1 '3': must be TIME SETTINGS"),
        ("3 outage loss=1", "'outage': must be one network by name"),
        ("3 lten", r"'lten': must be .*did you mean lte"),
        ("3 lte geo", "'geo': must be one network"),
        ("3 torture", "'torture' has a timeline itself"),
        ("3 loss=2", r"loss = 2.0: must be 0..1"),
        ("3 los=0.2", r"'los': there is no such setting; did you mean loss"),
        ("3 delay_s=0.1..0.2", "a ramp needs a later entry"),
        ("3 delay_s=0.1..99; 4 base", r"delay_s = 99.0: must be 0..60 s"),
        ("3 repeat; 4 base", "nothing may come after repeat"),
        ("3 reorder=0.5 keep_order=true", "entry at 3 s: reorder = 0.5"),
    ],
)
def test_a_timeline_that_cannot_be_is_refused_with_entry_value_and_range(schedule, text):
    with pytest.raises(ParameterError, match=text):
        link(schedule)
    with pytest.raises(ScenarioError, match=rf"user1.link.up.schedule: .*{text}"):
        load("carry_16ms", settings_texts=[f"link.schedule={schedule}", "link.keep_order=false"])


def test_no_packet_waits_for_a_distribution_that_a_timeline_brings_later(monkeypatch):
    """Its library takes 0.3 s to load: a whole outage where an emulator does it in between."""
    asked = []
    law = replace(DISTRIBUTIONS["gamma"], at=lambda params, u: asked.append(u) or 0.0)
    monkeypatch.setitem(DISTRIBUTIONS, "gamma", law)
    link("5 loss=0.1")
    assert not asked
    link("5 jitter=gamma jitter_s=0.01")
    assert asked
