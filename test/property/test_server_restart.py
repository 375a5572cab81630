# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A server that is killed and started again: what the links give out is judged all the time."""

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from pmwvc_analysis.budget import energy
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces import server_starts
from pmwvc_analysis.traces.holes import holes
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_bringup import scenarios as files
from pmwvc_core.account import continued
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.simulation.session import SteppedSession

STEP_NS = 8_000_000
ENERGIES = ("energy_u_s", "energy_v_s")


class TwoServers:
    """A server, nothing, and another server, in place of one."""

    def __init__(self, scenario, dead_ns, again_ns):
        self._first, self._second = ServerEnd(scenario), ServerEnd(scenario)
        self._second._epochs = [epoch + 100 for epoch in self._second._epochs]
        self._dead_ns, self._again_ns = dead_ns, again_ns
        self.present = self._first

    def __getattr__(self, name):
        return getattr(self.present, name)

    def tick(self, now_ns, packets, missed_s=0.0):
        if self._dead_ns <= now_ns < self._again_ns:
            return [None for _ in packets], None
        if now_ns >= self._again_ns:
            self.present = self._second
        return self.present.tick(now_ns, packets, missed_s)


def restarted(dead_step, away_steps, *, channel="strict", unrecorded=0):
    """Return a session whose server is dead for some steps, as it would be read from a recording;
    so many of the new server's first steps are not recorded.
    """
    texts = [f"channel={channel}", "link.delay_s=0.016", "operator.stiffness=120"]
    texts += ["master.store_j=0", "server.store_j=0"]  # a leak is judged, not what is declared
    scenario = files.load("wall", settings_texts=texts, duration_s=4.0)
    batch = SteppedSession(scenario)
    again = dead_step + away_steps
    batch.server = TwoServers(scenario, dead_step * STEP_NS, again * STEP_NS)
    batch.run(lambda _: None)
    traces = batch.traces()
    server = traces.server
    server.time_s = np.array([step.tick for step in batch.steps]) * batch.tick_s
    server.step = np.concatenate(
        [1 + np.arange(dead_step), 1 + np.arange(len(server.time_s) - dead_step)]
    )
    for name in ENERGIES:
        setattr(server, name, [continued(each, [dead_step]) for each in getattr(server, name)])
    kept = np.r_[0:dead_step, dead_step + unrecorded : len(server.step)]
    for name in ("time_s", "step", "periods_s"):
        setattr(server, name, getattr(server, name)[kept])
    for name in (*ENERGIES, "f_s", "xd_s"):
        setattr(server, name, [each[kept] for each in getattr(server, name)])
    return traces, scenario


def ports(traces, scenario):
    found = passivity(traces, scenario, None)
    return {each.part: each for each in found.of("user1")}


@example(dead=291, away=71, unrecorded=0)
@settings(max_examples=8, phases=(Phase.explicit, Phase.generate))
@given(
    dead=st.integers(200, 330),
    away=st.integers(1, 120),
    unrecorded=st.sampled_from([0, 0, 1, 3, 40]),
)
def test_a_restart_at_any_time_takes_nothing_from_a_passive_link(dead, away, unrecorded):
    traces, scenario = restarted(dead, away, unrecorded=unrecorded)
    (entry,) = user_energies(traces, scenario)
    for way in (entry.up, entry.down, entry.joint):
        assert way.minimum_j >= -1e-12
        gaps = np.diff(way.time_s)
        assert gaps.max() < 0.009 + 0.008 * unrecorded  # judged while no server ran, too
    for port in ports(traces, scenario).values():
        assert port.passive or (unrecorded and port.passive is None)
    # what went to no server is not there for the new one: next to nothing is left over
    after = entry.up.time_s >= (dead + away) * 0.008
    assert entry.up.balance_j[after][0] < entry.up.balance_j[~after].max() + 2e-3


LEAK_J, LEAK_S = 2e-3, 3.6


def leaking(way):
    """Return a session whose server is dead for 1.5 s, with a leak one way a while after that."""
    traces, scenario = restarted(240, 190)
    assert all(port.passive for port in ports(traces, scenario).values())
    (user,), server = traces.users, traces.server
    blocks = user.block_time_s > LEAK_S
    if way == "up":
        server.energy_u_s[0][server.time_s > LEAK_S] += LEAK_J
    elif way == "down":
        user.energy["v_m"][blocks] += LEAK_J
    else:
        user.energy["device"][blocks] -= LEAK_J
    return traces, scenario


@pytest.mark.parametrize("way", ["up", "down", "hand_port"])
def test_a_millijoule_that_is_made_after_a_restart_is_found(way):
    found = ports(*leaking(way))[way]
    assert found.passive is False
    assert found.since_s == pytest.approx(LEAK_S, abs=0.02)
    assert found.least_j == pytest.approx(-LEAK_J, abs=0.15 * LEAK_J)


def test_what_died_with_a_server_would_hide_it(monkeypatch):
    """The control: packets that came while no server ran still count as held."""
    monkeypatch.setattr(energy, "died_up", lambda times, *_: np.zeros(len(times)))
    assert ports(*leaking("hand_port"))["hand_port"].passive


def test_a_server_that_was_started_again_gives_out_nothing_that_the_one_before_held():
    traces, scenario = restarted(300, 100)
    server = traces.server
    (before,) = passivity(traces, scenario, None).of("server")
    assert before.passive
    taken_j = server.energy_u_s[0] - server.energy_v_s[0]
    held_j = taken_j[299]  # spring and damper
    assert held_j > 4e-4
    own_j = taken_j[-1] - held_j  # of the new server
    server.energy_v_s[0][server.time_s > LEAK_S] += own_j + 0.5 * held_j
    (after,) = passivity(traces, scenario, None).of("server")
    assert after.passive is False
    assert after.least_j == pytest.approx(-0.5 * held_j, rel=0.1)


def test_steps_that_a_killed_server_did_not_record_are_found_in_its_packets():
    traces, scenario = restarted(260, 60)
    expected = user_energies(traces, scenario)[0].down
    server = traces.server
    kept = np.r_[0:257, 260 : len(server.step)]  # three steps were sent and not recorded
    lost_j = server.energy_v_s[0][259] - server.energy_v_s[0][256]
    assert lost_j > 4e-6
    for name in ("time_s", "step", "periods_s"):
        setattr(server, name, getattr(server, name)[kept])
    for name in (*ENERGIES, "f_s", "xd_s"):
        setattr(server, name, [each[kept] for each in getattr(server, name)])
    for sums in (server.energy_u_s[0], server.energy_v_s[0]):
        sums[257:] -= lost_j if sums is server.energy_v_s[0] else 0.0
    found = user_energies(traces, scenario)[0].down
    np.testing.assert_allclose(found.balance_j[-50:], expected.balance_j[-50:], atol=1e-12)


def lost_end(dead, unrecorded, unseen):
    """Return a session of whose first server the last steps are not recorded, and its last packets
    neither.
    """
    traces, scenario = restarted(dead, 60)
    server = traces.server
    kept = np.r_[0 : dead - unrecorded, dead : len(server.step)]
    lost_j = {
        name: getattr(server, name)[0][dead - 1] - getattr(server, name)[0][dead - unrecorded - 1]
        for name in ENERGIES
    }
    for name in ("time_s", "step", "periods_s"):
        setattr(server, name, getattr(server, name)[kept])
    for name in (*ENERGIES, "f_s", "xd_s"):
        setattr(server, name, [each[kept] for each in getattr(server, name)])
    for name in ENERGIES:  # the next server's begin where those on record end
        getattr(server, name)[0][dead - unrecorded :] -= lost_j[name] * (1.0 - 1e-12)
    for topic, packets in traces.packets.items():
        if "wave_down" in topic:
            since_s = (dead - unseen) * 0.008 - 0.004
            rows = (packets.time_s < since_s) | (packets.time_s > (dead + 30) * 0.008)
            for name in ("time_s", "epoch", "seq", "sent_ns", "period_s", "wave", "integral",
                         "energy", "position"):  # fmt: skip
                setattr(packets, name, getattr(packets, name)[rows])
    return traces, scenario


@settings(max_examples=8, phases=(Phase.explicit, Phase.generate))
@example(dead=262, unrecorded=80, unseen=80)
@given(dead=st.integers(240, 330), unrecorded=st.integers(5, 90), unseen=st.integers(0, 90))
def test_what_a_killed_server_did_unrecorded_is_a_hole_and_no_violation(dead, unrecorded, unseen):
    traces, scenario = lost_end(dead, unrecorded, min(unseen, unrecorded))
    for port in ports(traces, scenario).values():
        assert port.passive is not False, port
    killed = [hole for hole in holes(traces) if hole.end_s < (dead + 6) * 0.008]
    assert [hole.owner for hole in killed] == ["server"]
    assert killed[0].start_s == pytest.approx((dead - unrecorded) * 0.008, abs=0.009)
    assert killed[0].end_s > (dead - 5) * 0.008


def test_taken_as_if_it_had_stopped_it_would_be_a_violation(monkeypatch):
    """The control."""
    traces, scenario = lost_end(262, 80, 80)
    monkeypatch.setattr(server_starts, "_received", lambda *_: (0.0, -np.inf))
    assert ports(traces, scenario)["down"].passive is False
