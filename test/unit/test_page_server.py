# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server of the page: what a page may send, and what it is sent."""

import asyncio
import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest
from support.page_sockets import PATIENCE_S, HandmadeSession, served
from support.plain import load
from websockets.exceptions import ConnectionClosed

from pmwvc_view import controls, protocol
from pmwvc_view.description import NICE, Predictor
from pmwvc_view.protocol import CREDITS, MESSAGE_BYTES
from pmwvc_view.session import Handled
from pmwvc_view.simulated import SimulatedSession
from pmwvc_view.web.client import MOST_AT_ONCE


@pytest.fixture
def server():
    with served(HandmadeSession()) as running:
        yield running


def closed_with(page):
    """Read on until the socket is closed; return the code."""
    with pytest.raises(ConnectionClosed) as caught:
        while True:
            page.receive()
    return caught.value.rcvd.code


def test_process_of_the_model_is_not_ended_by_a_ctrl_c_that_reaches_the_whole_terminal():
    predictor = Predictor(live=False)
    try:
        assert asyncio.run(predictor.ask(load("wall"), {}))["stable"]
        (worker,) = predictor._pool._processes
        assert os.getpriority(os.PRIO_PROCESS, worker) == min(os.nice(0) + NICE, 19)
        status = Path(f"/proc/{worker}/status").read_text("ascii")
        blocked = int(status.partition("SigBlk:")[2].split()[0], 16)
        assert blocked >> (signal.SIGINT - 1) & 1
        assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())  # here it is not
    finally:
        predictor.close()


def test_handle_has_one_owner_and_is_free_again_once_that_page_is_gone(server):
    targets = server.session.targets
    with server.page() as second:
        with server.page() as first:
            assert first.ask("take", user="user1")["done"]
            refused = second.ask("take", user="user1")
            assert not refused["done"] and "another page" in refused["text"]
            second.send("target", user="user1", position=[0.5])
            first.send("target", user="user1", position=[0.1])
            assert targets.get(timeout=PATIENCE_S) == ("user1", (0.1,))
            assert second.ask("take", user="user2")["done"]
        assert targets.get(timeout=PATIENCE_S) == ("user1", None)
        while second.await_kind("users")["users"][0]["holder"] is not None:
            pass
        assert second.ask("take", user="user1")["done"]


def test_page_that_sends_no_targets_any_more_lets_go_and_takes_hold_again(server):
    targets = server.session.targets
    with server.page() as page:
        page.ask("take", user="user1")
        page.send("target", user="user1", position=[0.1])
        assert targets.get(timeout=PATIENCE_S) == ("user1", (0.1,))
        assert targets.get(timeout=PATIENCE_S) == ("user1", None)  # nothing was sent: too old
        page.send("target", user="user1", position=[0.2])
        assert targets.get(timeout=PATIENCE_S) == ("user1", (0.2,))


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("hello", 1008),
        ('{"kind": "nothing"}', 1008),
        ('{"kind": "target", "user": "user1", "position": [1e999]}', 1008),
        ('{"kind": "take", "user": "user1", "force": 8}', 1008),
        (b"\0" * 8, 1008),
        ("x" * (MESSAGE_BYTES + 1), 1009),
    ],
)
def test_page_that_breaks_the_rules_is_closed_and_its_hand_opened(server, message, code):
    with server.page() as page:
        page.ask("take", user="user1")
        page.socket.send(message)
        assert closed_with(page) == code
    assert server.session.targets.get(timeout=PATIENCE_S) == ("user1", None)


def test_page_that_sends_more_than_a_hand_does_is_closed(server):
    with server.page() as page:
        with pytest.raises(ConnectionClosed) as caught:
            while True:
                page.send("seen", seq=0)
        assert caught.value.rcvd.code == 1008
        assert "more than 500 messages a second" in caught.value.rcvd.reason


def test_page_that_does_not_look_is_sent_no_more_than_its_credit_then_the_present(server):
    session = server.session
    with server.page() as page:
        sent = [page.receive() for _ in range(CREDITS)]
        assert all(isinstance(each, np.ndarray) for each in sent)
        session.peaks[session.polls + 20] = 3.0
        session.await_polls(60)
        page.send("pause", paused=True, id=1)
        assert page.receive() == {"kind": "answer", "id": 1, "done": True, "text": "paused"}
        page.send("seen", seq=int(sent[-1][0]))
        newest = page.receive()
    at = session.layout.slices
    assert newest[0] >= sent[-1][0] + 60
    assert newest[at["user1.f_max"]] == 3.0 and newest[at["user1.f_min"]] == -3.0
    packets = newest[session.layout.size :].reshape(-1, 5)
    numbers = packets[:, 0]
    assert np.array_equal(numbers, np.arange(sent[-1][0] + 1, newest[0] + 1))


QUESTIONS = 40  # at once, fewer than a page may send


def test_questions_as_many_as_a_page_may_send_are_dropped_before_any_work(monkeypatch):
    """Reading one costs milliseconds: the session's process reads none of them."""
    read_here, changed = [], controls.changed

    def counted(*given):
        read_here.append(given)
        return changed(*given)

    monkeypatch.setattr(controls, "changed", counted)
    session = SimulatedSession(load("wall"))
    with served(session) as server, server.page() as page:
        for number in range(QUESTIONS):
            page.send("ask", id=number, values={"link.delay_s": 0.02})
        while page.await_kind("prediction")["id"] != QUESTIONS - 1:
            pass
    assert not read_here


def test_message_that_comes_while_a_session_is_busy_is_handled_before_it_is_busy_again():
    """Its snapshots are never in time; without a moment for pages a message waits three polls."""
    session, wanted, polls, answered = HandmadeSession(), 40, 0, 0
    with served(session, snapshot_s=1e-9) as server, server.page() as page:
        page.ask("take", user="user1")
        session.busy = threading.Semaphore(0)
        may_send = True
        while answered < wanted:
            if session.targets.get(timeout=PATIENCE_S) is not None:
                may_send, answered = True, answered + 1
                continue
            if may_send:
                page.send("target", user="user1", position=[float(answered)])
            may_send, polls = False, polls + 1
            session.busy.release()
        session.busy.release(10**6)
    assert polls < 1.5 * wanted


def test_session_that_ends_tells_its_pages():
    session = HandmadeSession()
    session.report = "/sessions/one/report.html"
    with served(session) as server, server.page() as page:
        session.ended = "over"
        ended = page.await_kind("ended")
        assert ended.pop("report") == session.report
        assert ended == {"kind": "ended", "text": "over"}
        assert closed_with(page) == 1001


class StandstillSession(HandmadeSession):
    """The machine stands still when it is asked to pause: nobody sends, nobody listens."""

    async def pause(self, paused):
        threading.Event().wait(2.0 * protocol.SILENCE_S)
        return Handled(True)


def test_hand_is_not_let_go_because_the_machine_stood_still():
    session = StandstillSession()
    with served(session, snapshot_s=0.016) as server, server.page() as page:
        page.ask("take", user="user1")
        page.send("target", user="user1", position=[0.1])
        assert page.ask("pause", paused=True)["done"]
        page.send("target", user="user1", position=[0.2])
        found = [session.targets.get(timeout=PATIENCE_S) for _ in range(2)]
        assert found == [("user1", (0.1,)), ("user1", (0.2,))]


class SlowSession(HandmadeSession):
    """Changes last as long as it goes on; only the newest question is answered."""

    can = HandmadeSession.can | {"set", "ask", "restart"}

    async def set(self, path, value):
        await asyncio.Event().wait()

    async def ask(self, values):
        return None

    def restart(self, values):
        return Handled(True, "beginning again")


def test_page_that_asks_for_too_much_at_once_is_told_and_hands_go_on():
    with served(SlowSession()) as server, server.page() as page, server.page() as other:
        for number in range(30):
            page.send("set", id=1000 + number, path="link.delay_s", value=0.01)
        refused = [page.await_kind("answer") for _ in range(30 - MOST_AT_ONCE)]
        assert not any(answer["done"] for answer in refused)
        assert "under way" in refused[0]["text"]
        assert other.ask("take", user="user1")["done"]
        restarts = [page.ask("restart", values={}) for _ in range(5)]
        assert [answer["done"] for answer in restarts] == [True] + 4 * [False]
        dropped = page.ask("ask", values={})
        assert (dropped["done"], dropped["text"]) == (False, "a newer question came")
