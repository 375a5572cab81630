# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A plug-in environment is asked in a thread: waited for, left alone while busy, asked again."""

import threading

import pytest

from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Unanswered
from pmwvc_core.server.black_box import directly
from pmwvc_server.asking import Worker, caller


def test_what_comes_with_the_project_is_asked_directly_a_plug_in_through_a_thread():
    assert caller(ServerParams()) is directly
    assert caller(ServerParams(coupling="unknown", environment="hunt_crossley")) is directly
    assert isinstance(caller(ServerParams(coupling="unknown", environment="jelly")), Worker)


def test_an_answer_comes_back_from_another_thread():
    worker = Worker(30.0)
    assert worker(threading.current_thread) is not threading.current_thread()
    assert [worker(lambda n=n: n * n) for n in range(5)] == [0, 1, 4, 9, 16]


@pytest.mark.parametrize("error", [ZeroDivisionError("no mass"), SystemExit("bye")], ids=repr)
def test_what_the_environment_raises_is_raised_and_its_thread_goes_on(error):
    def fails():
        raise error

    worker = Worker(30.0)
    with pytest.raises(type(error), match=str(error)):
        worker(fails)
    assert worker(lambda: 7) == 7


def test_a_hanging_environment_is_left_alone_until_it_is_back_and_its_late_answer_is_dropped():
    release, asked = threading.Event(), []

    def hangs():
        release.wait()
        return "late"

    worker = Worker(0.001)
    with pytest.raises(Unanswered, match=r"has not answered within 1 ms"):
        worker(hangs)
    for _ in range(3):
        with pytest.raises(Unanswered, match=r"is still busy with the step of \d+\.\d+ s ago"):
            worker(lambda: asked.append(1))
    assert asked == []
    release.set()
    assert worker._answer.result(30.0) == "late"  # it is back
    worker._patience_s = 30.0
    assert worker(lambda: "new") == "new"
