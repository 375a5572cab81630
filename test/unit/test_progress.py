# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Work that lasts is named on stderr; work that does not is not."""

import io
import json
import subprocess
import sys
import threading

import pytest
from rich.console import Console

from pmwvc_bringup import output
from pmwvc_bringup.output import doing


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


def test_each_part_that_lasts_is_one_plain_line_where_there_is_no_terminal():
    stream = Stream()
    with doing("reading", Console(file=stream)) as work:
        stream.await_text("reading\n")
        work.part("drawing")
        stream.await_text("drawing\n")
    assert stream.getvalue() == "reading\ndrawing\n"


def test_a_ratio_is_repeated_after_a_while_and_not_at_once(monkeypatch):
    stream = Stream()
    with doing("simulating", Console(file=stream)) as work:
        stream.await_text("simulating\n")
        for ratio in (0.1, 0.2, 0.3):
            work(ratio)
        assert stream.getvalue() == "simulating\n"
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
