# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a terminal and a log show of work that lasts, and of a session that runs."""

import io

from rich.console import Console

from pmwvc_bringup.output import doing
from pmwvc_bringup.session.terminal import user_words


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


def test_a_line_shows_all_of_a_user():
    text = user_words("user1", 1000.4, 125.0, (0.0172, 0.0168), -1.5, 1, True)
    assert text == "user1 1000 Hz 125/s 17.2/16.8 ms -1.50 N coupled, contact"
    assert user_words("user2", None, None, None, None, None, False) == "user2 - - - - no data"
