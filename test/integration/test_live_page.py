# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a real session: people take hold through it, change the nodes, and go away."""

import numpy as np
import pytest
from support.excuses import unless_stalled
from support.verdicts import LATE_S, loops_stood_still
from support.visits import visited as visit

pytestmark = pytest.mark.integration
SILENT_S, FADE_S = 0.15, 0.1  # what a hand without targets is promised
DELIVERY_S = 0.05  # from the last target's sending to the master


@pytest.fixture(scope="module")
def visited(tmp_path_factory):
    """A session with a page, which two people take part in."""
    return visit(tmp_path_factory.mktemp("page") / "session")


def test_drag_on_the_page_lifts_the_measured_force(visited):
    assert visited["before"] < 0.05
    assert visited["squeezed"] > 1.0


def test_second_page_for_one_handle_is_refused(visited):
    assert not visited["second tab"]["done"]
    assert "another page" in visited["second tab"]["text"]


def test_setting_of_the_page_changes_the_running_nodes_and_wrong_ones_are_refused(visited):
    assert visited["delay"]["done"], visited["delay"]
    for name in ("server.contact_stiffness", "master.impedance"):
        assert visited[name]["done"], visited[name]
    assert not visited["beyond"]["done"] and "0..1" in visited["beyond"]["text"]
    assert not visited["elsewhere"]["done"]
    last = visited["traces"].fates["user1/up"]
    delays = (last.time_out_ns - last.time_in_ns)[last.time_out_ns > 0][-20:] * 1e-9
    assert np.median(delays) == pytest.approx(0.02, abs=0.002)


def test_delay_that_grows_by_the_page_drops_nobody(visited):
    """Waves or watchdog: a step of the delay beyond 30 ms would; a machine that stalls may."""
    traces = visited["traces"]
    frame_s = visited["scenario"].users[0].master.frame_s
    gaps_ns = [np.diff(fate.time_in_ns).max() for fate in traces.fates.values()]
    emulator_stood = max(gaps_ns) * 1e-9 > frame_s + LATE_S  # it took packets in late
    for user in traces.users:
        with unless_stalled(lambda: emulator_stood or loops_stood_still(traces, traces.users)):
            assert not (user.state == 2).any()


def test_hand_of_a_page_that_is_gone_opens_in_time(visited):
    traces = visited["traces"]
    user = traces.users[0]
    brake = visited["scenario"].users[0].operator.remote.brake
    times = traces.targets["user1"].time_s
    held = times[np.isfinite(traces.targets["user1"].position[:, 0])]
    gripping = np.abs(user.f_h[:, 0] + brake * user.xd_m[:, 0]) > 1e-6
    last_s = user.time_s[gripping][-1]
    assert last_s - held[-1] <= SILENT_S + FADE_S + DELIVERY_S


def test_force_never_jumps_by_more_than_the_slew_limit(visited):
    for user, settings in zip(visited["traces"].users, visited["scenario"].users, strict=True):
        steps = np.abs(np.diff(user.f_applied[:, 0]))
        consecutive = np.diff(user.tick) == 1
        assert steps[consecutive].max() <= settings.safety.max_slew * user.tick_s + 1e-9
