# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a terminal and a log show of work that lasts, and of a session that runs."""

import io
from dataclasses import replace

from rich.console import Console

from pmwvc_bringup.output import doing
from pmwvc_bringup.session.terminal import UserStatus, status_line

TIMES = {"elapsed_s": 2.0, "duration_s": 10.0}
COUPLED = UserStatus("user1", 1000.4, 125.0, force_n=-1.5, state=1, contact=True)


def test_a_terminal_shows_a_bar_of_each_part_and_is_left_as_it_was():
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, force_interactive=True, width=80)
    with doing("simulating", console) as work:
        work(0.5)
        assert "simulating" in stream.getvalue() and "100%" not in stream.getvalue()
        work.part("drawing")
        work(1.0)
    assert "drawing" in stream.getvalue() and "100%" in stream.getvalue()
    assert stream.getvalue().endswith("\x1b[1A\x1b[2K")  # the bar's line is erased


def test_nothing_of_it_is_written_where_there_is_no_terminal():
    stream = io.StringIO()
    with doing("reading", Console(file=stream)) as work:
        work(0.3)
        work.part("drawing")
    assert stream.getvalue() == ""


def test_a_line_shows_all_of_every_user():
    seen, ended = replace(COUPLED, up_s=0.0172, down_s=0.0168), ["netem was ended by SIGKILL"]
    text = status_line([COUPLED, UserStatus("user2"), seen], ended, **TIMES)
    own = "1000 Hz 125/s {} -1.50 N coupled, contact"
    assert text == (
        f"   2.0 / 10 s | user1 {own.format('-')} | user2 - - - - no data"
        f" | user1 {own.format('17.2/16.8 ms')} | netem was ended by SIGKILL"
    )
