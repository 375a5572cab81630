# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a real session: people take hold through it, change the nodes, and go away."""

import signal
import socket

import numpy as np
import pytest
from support.live_pages import address_of, opened
from support.page_sockets import Page
from support.sessions import Running
from support.verdicts import LATE_S, loops_stood_still

from pmwvc_analysis.recording.reader import read_scenario, read_session

pytestmark = pytest.mark.integration
SILENT_TICKS, FADE_TICKS = 150, 100  # what a hand without targets is promised
DELIVERY_TICKS = 50  # from the last target's sending to the master


class Person:
    """A page whose hand follows a target, as a pointer would: one target a snapshot."""

    def __init__(self, page: Page, user: str) -> None:
        self.page, self.user = page, user
        self.columns, at = {}, 0
        for name, count, _ in page.session["layout"]["columns"]:
            self.columns[name] = slice(at, at + count)
            at += count
        self.target: float | None = None
        self.row = np.full(at, np.nan)
        assert page.ask("take", user=user)["done"]

    def value(self, name: str) -> float:
        """Return a number of the newest snapshot."""
        return float(self.row[self.columns[name]][0])

    def look(self) -> None:
        """Take in the next message; send a target for a snapshot."""
        found = self.page.receive()
        if isinstance(found, np.ndarray):
            self.row = found
            self.page.send("seen", seq=int(found[0]))
            if self.target is not None:
                self.page.send("target", user=self.user, position=[self.target])


def until(condition, *people):
    """Let people look in turns until a condition holds."""
    while not condition():
        for person in people:
            person.look()


@pytest.fixture(scope="module")
def visited(tmp_path_factory):
    """A session in which two people squeeze the cube, and one of them leaves."""
    folder = tmp_path_factory.mktemp("page") / "session"
    found = {"folder": folder}
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    words = ("live", "--view", "--no-browser", "--port", port, "--duration", "300")
    with Running(folder, *words) as session:
        address = address_of(session.process.stdout)
        assert f":{port}/" in address
        with opened(address) as second_socket:
            second = Person(Page(second_socket, ""), "user2")
            with opened(address) as first_socket:
                first = Person(Page(first_socket, ""), "user1")
                both = (first, second)
                until(lambda: first.value("user1.state") == first.value("user2.state") == 1, *both)
                found["before"] = abs(first.value("user1.f_applied"))
                found["second tab"] = second.page.ask("take", user="user1")
                first.target, second.target = -0.016, 0.016
                until(lambda: abs(first.value("user1.f_applied")) > 1.0, *both)
                found["squeezed"] = abs(first.value("user1.f_applied"))
                second.target = None  # its hand lets go by silence; asking takes its time
                found["delay"] = first.page.ask("set", path="link.delay_s", value=0.02)
                found["beyond"] = first.page.ask("set", path="link.loss", value=2.0)
                found["elsewhere"] = first.page.ask("set", path="device.plugin", value="x")
                for name, value in (
                    ("server.contact_stiffness", 800.0),
                    ("master.impedance", 30.0),
                ):
                    found[name] = first.page.ask("set", path=name, value=value)
                second.target = 0.016
                until(lambda: abs(first.value("user1.f_applied")) > 1.0, *both)
            until(lambda: second.value("user1.held") == 0.0, second)
            left_s = second.value("time_s")
            until(lambda: second.value("time_s") > left_s + 1.0, second)
            # Its place is free once the server has seen that its socket is gone.
            until(lambda: second.page.ask("take", user="user1")["done"], second)
        session.process.send_signal(signal.SIGINT)
        session.end()
    found["traces"], found["scenario"] = read_session(folder), read_scenario(folder)
    return found


def test_drag_on_the_page_lifts_the_measured_force(visited):
    assert visited["before"] < 0.05
    assert visited["squeezed"] > 1.0


def test_second_page_for_one_handle_is_refused(visited):
    assert not visited["second tab"]["done"]
    assert "another page" in visited["second tab"]["text"]


def test_setting_of_the_page_changes_the_running_nodes_and_wrong_ones_are_refused(visited):
    assert visited["delay"]["done"], visited["delay"]
    assert visited["server.contact_stiffness"]["done"] and visited["master.impedance"]["done"]
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
        stalled = emulator_stood or loops_stood_still(traces, [user])
        assert stalled or not (user.state == 2).any()


def test_hand_of_a_page_that_is_gone_opens_in_time(visited):
    traces = visited["traces"]
    user = traces.users[0]
    brake = visited["scenario"].users[0].operator.remote.brake
    times = traces.targets["user1"].time_s
    held = times[np.isfinite(traces.targets["user1"].position[:, 0])]
    gripping = np.abs(user.f_h[:, 0] + brake * user.xd_m[:, 0]) > 1e-6
    last = user.tick[np.flatnonzero(gripping)[-1]]
    let_go = user.tick[np.searchsorted(user.time_s, held[-1])]
    assert last - let_go <= SILENT_TICKS + FADE_TICKS + DELIVERY_TICKS


def test_force_never_jumps_by_more_than_the_slew_limit(visited):
    for user, settings in zip(visited["traces"].users, visited["scenario"].users, strict=True):
        steps = np.abs(np.diff(user.f_applied[:, 0]))
        consecutive = np.diff(user.tick) == 1
        assert steps[consecutive].max() <= settings.safety.max_slew * user.tick_s + 1e-9
