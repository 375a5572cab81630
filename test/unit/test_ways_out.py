# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the command line answers to a mistake, how it prints numbers at the edge of reading, and
what a terminal shows of work that lasts.
"""

import io
from pathlib import Path

import pytest
from rich.console import Console

from pmwvc_bringup import output, scenarios
from pmwvc_bringup.output import doing
from pmwvc_bringup.session.terminal import user_words
from pmwvc_core.errors import ScenarioError
from pmwvc_core.words import cell, quantity, share

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("setting", "told", "not_told"),
    [
        ("impedance=30", "did you mean master.impedance?", "must be"),
        ("MASTER.IMPEDANCE=30", "did you mean master.impedance?", "must be"),
        ("Link.Delay_s=0.1", "did you mean link.delay_s?", "must be"),
        ("xyzxyz=30", "there is no such parameter", "did you mean"),
        ("link.loss=-1", "must be", "did you mean"),
        ("user1.server.contact_stifness=3", "mean user1.server.contact_stiffness?", "must be"),
        ("link.prest=lte", "did you mean link.preset?", "must be"),
        ("user1.dof=2", "shared by all", "did you mean"),
    ],
)
def test_a_wrong_setting_gets_the_way_out_that_fits(setting, told, not_told):
    with pytest.raises(ScenarioError) as caught:
        scenarios.load("wall", settings_texts=[setting])
    assert told in str(caught.value) and not_told not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (quantity(-3.84, "J"), "-3.84 J"),
        (quantity(4.5e-7, "J"), "450 nJ"),
        *((quantity(value, "J"), "–") for value in (None, float("nan"))),
        (quantity(-4.2e-17, "J"), "0 J"),  # rounding
        (quantity(-0.384, "J"), "-384 mJ"),
        (cell(-4.2e-17, 1e3), "0"),
        (cell(-3.84, 1e3), "-3840"),
        (cell(0.012345), "0.0123"),
        (cell([1.0, None]), "1, –"),
        (cell(True), "yes"),
        (share(1.5286), "1.53 times"),
        (share(0.0075), "0.75 % of"),
        (share(1.0), "100.00 % of"),
    ],
)
def test_a_number_reads_well_and_rounding_is_zero(text, expected):
    assert text == expected


def test_every_table_of_a_report_that_scrolls_is_reached_by_keyboard():
    folder = ROOT / "pmwvc_analysis" / "pmwvc_analysis" / "report"
    texts = [file.read_text("utf-8") for file in folder.glob("*_template.html")]
    assert sum(text.count('class="scroll"') for text in texts) > 10
    for text in texts:
        assert text.count('class="scroll"') == text.count('class="scroll" tabindex="0"')


def test_a_terminal_shows_a_bar_of_each_part_and_is_left_as_it_was(monkeypatch):
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, force_interactive=True, width=80)
    monkeypatch.setattr(output, "terminal", lambda **_: console)
    with doing("simulating") as work:
        work(0.5)
        assert "simulating" in stream.getvalue() and "100%" not in stream.getvalue()
        work.part("drawing")
        work(1.0)
    assert "drawing" in stream.getvalue() and "100%" in stream.getvalue()
    assert stream.getvalue().endswith("\x1b[1A\x1b[2K")  # the bar's line is erased


def test_nothing_of_it_is_written_where_there_is_no_terminal(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(output, "terminal", lambda **_: Console(file=stream))
    with doing("reading") as work:
        work(0.3)
        work.part("drawing")
    assert stream.getvalue() == ""


def test_a_line_shows_all_of_a_user():
    text = user_words("user1", 1000.4, 125.0, (0.0172, 0.0168), -1.5, 1, True)
    assert text == "user1 1000 Hz 125/s 17.2/16.8 ms -1.50 N coupled, contact"
    assert user_words("user2", None, None, None, None, None, False) == "user2 - - - - no data"
