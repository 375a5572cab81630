# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a terminal and a log show of work that lasts, and of a session that runs."""

import io
import json
import subprocess
import sys
import threading
from dataclasses import replace

import pytest
from rich.console import Console

from pmwvc_bringup import output
from pmwvc_bringup.output import doing
from pmwvc_bringup.session.terminal import UserStatus, status_line, status_table

TIMES = {"elapsed_s": 2.0, "duration_s": 10.0}
COUPLED = UserStatus("user1", 1000.4, 125.0, force_n=-1.5, state=1, contact=True)


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    monkeypatch.setattr(output, "QUIET_S", 0.0)


class Stream(io.StringIO):
    """A stream that tells when it holds a text."""

    def __init__(self):
        super().__init__()
        self.news = threading.Condition()

    def write(self, text):
        with self.news:
            super().write(text)
            self.news.notify_all()
        return len(text)

    def await_text(self, text):
        with self.news:
            assert self.news.wait_for(lambda: text in self.getvalue(), 30.0), self.getvalue()


def test_parts_that_last_are_lines_where_there_is_no_terminal_and_ratios_again_later(monkeypatch):
    stream = Stream()
    with doing("reading", Console(file=stream)) as work:
        stream.await_text("reading\n")
        work(0.3)
        work.part("drawing")
        stream.await_text("drawing\n")
        assert stream.getvalue() == "reading\ndrawing\n"
        monkeypatch.setattr(output, "LINE_S", 0.0)
        work.part("writing")
        stream.await_text("writing\n")
        work(0.5)
        stream.await_text("writing: 50 %\n")


def test_work_that_does_not_last_is_not_mentioned(monkeypatch):
    stream = Stream()
    monkeypatch.setattr(output, "QUIET_S", 1e6)
    with doing("reading", Console(file=stream)) as work:
        work.part("drawing")
        work(1.0)
    assert stream.getvalue() == ""


def test_a_terminal_shows_a_bar_and_is_left_as_it_was():
    stream = Stream()
    console = Console(file=stream, force_terminal=True, force_interactive=True, width=80)
    with doing("simulating", console) as work:
        stream.await_text("simulating")
        work(0.5)
        work.part("drawing")
        stream.await_text("drawing")
    assert stream.getvalue().endswith("\x1b[1A\x1b[2K")  # the bar's line is erased


def test_a_document_holds_nothing_of_it(tmp_path):
    words = ["simulate", "wall", "--duration", "2", "--json", "--out", str(tmp_path / "session")]
    code = f"from pmwvc_bringup import cli, output; output.QUIET_S = 0.0; cli.main({words})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert json.loads(result.stdout)["scenario"] == "wall"
    for part in ("simulating", "drawing the figures"):
        assert any(line.startswith(part) for line in result.stderr.splitlines())
    assert "\x1b" not in result.stderr


def test_a_line_and_a_table_show_all_of_every_user():
    seen, ended = replace(COUPLED, up_s=0.0172, down_s=0.0168), ["netem was ended by SIGKILL"]
    text = status_line([COUPLED, UserStatus("user2"), seen], ended, **TIMES)
    own = "1000 Hz 125/s {} -1.50 N coupled, contact"
    assert text == (
        f"   2.0 / 10 s | user1 {own.format('-')} | user2 - - - - no data"
        f" | user1 {own.format('17.2/16.8 ms')} | netem was ended by SIGKILL"
    )
    console = Console(file=io.StringIO(), width=120)
    console.print(status_table([seen], ended, **TIMES))
    for part in ("user1", "1000 Hz", "125/s", "17.2/16.8 ms", "-1.50 N", "SIGKILL"):
        assert part in console.file.getvalue()
