# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The course: every number is what its sessions give, every command runs them."""

import dataclasses
import functools
import re
import shlex
import tempfile
from decimal import Decimal
from pathlib import Path

import pytest

from course.first_half import HUM
from course.page import Watched, watch
from course.step import PLAIN, Run, Session, document, simulated
from course.watching import WATCHED
from course.written import NUMBERS, STEPS, pages, read
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_bringup import scenarios
from pmwvc_bringup.cli import build_parser

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "course"
FIRST = STEPS[0].runs["near"]
LIVE = "view live"  # a person takes part; nothing on a page is said of its numbers
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.]*\d)")


def page_of(step):
    return (FOLDER / f"{step.name}.md").read_text("utf-8")


def commands(page):
    """Return every command line of a page, with ``./pmwvc``."""
    yield from re.findall(r"^(?:    )?(\./pmwvc .*)$", page, re.MULTILINE)
    yield from re.findall(r"`(\./pmwvc .*?)`", page)


def asked(command):
    """Return the scenario that a command line is about."""
    words = shlex.split(command.removeprefix("./pmwvc "))
    arguments = build_parser().parse_args(words)
    name = getattr(arguments, "scenario", None) or arguments.what
    duration_s = getattr(arguments, "duration", None)
    return scenarios.load(name, settings_texts=arguments.settings, duration_s=duration_s)


@functools.cache
def sessions(name):
    """Return the sessions of a step, each as the command line has it that its page prints; the
    first one of all is run by it, and read from the folder that it wrote.
    """
    (step,) = [step for step in STEPS if step.name == name]
    return dict(run_as_printed(step))


def run_as_printed(step):
    """Yield name and session of each run of a step."""
    for key, run in step.runs.items():
        assert asked(run.command) == run.load()
        if run is not FIRST:
            yield key, simulated(run)
            continue
        with tempfile.TemporaryDirectory() as folder:
            summary = document(run.command, "--no-figures", "--out", folder)
            yield key, Session(read_scenario(folder), read_session(folder), summary)


def test_there_are_ten_steps_and_a_page_for_each():
    assert len(STEPS) == 10
    assert {page.name for page in FOLDER.glob("*.md")} == set(pages(read(FOLDER)))


@pytest.mark.parametrize("name", [step.name + ".md" for step in STEPS] + ["README.md"])
def test_a_page_is_what_its_template_and_the_numbers_give(name):
    page = (FOLDER / name).read_text("utf-8")
    assert page == pages(read(FOLDER))[name], "run make course"
    for target in re.findall(r"\]\(([^)#]+)", page):
        assert (FOLDER / target).exists(), target


def other_numbers(page, again):
    """Return the numbers of a page that those found again do not round to.

    A session in virtual time is repeated but for rounding, so that only a last digit may turn.
    """
    assert NUMBER.sub("#", page) == NUMBER.sub("#", again)
    return [
        (shown, found)
        for shown, found in zip(NUMBER.findall(page), NUMBER.findall(again), strict=True)
        if abs(Decimal(shown) - Decimal(found)) > Decimal(1).scaleb(Decimal(shown).as_tuple()[2])
    ]


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.name)
def test_the_numbers_of_a_page_are_those_of_the_commands_that_it_prints(step):
    watched = WATCHED[step.name]
    shown, levels = watch(watched)
    assert levels == [watched.before, watched.after][: 1 + bool(watched.settings)]
    found = step.numbers(sessions(step.name)) | step.answers() | shown
    again = pages(read(FOLDER) | {step.name: found})[f"{step.name}.md"]
    assert other_numbers(page_of(step), again) == [], "run make course"


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.name)
def test_every_command_of_a_page_is_run_for_its_numbers_and_its_page_is_the_one_watched(step):
    watched = WATCHED[step.name]
    owners = [*step.runs.values(), *step.questions.values(), watched]
    printed = [each for each in commands(page_of(step)) if LIVE not in each]
    assert set(printed) <= {owner.command for owner in owners}
    before = STEPS[0].runs["far"]  # whose picture step 2 shows beside its own
    needed = {owner.command for owner in owners if owner != before or step is STEPS[0]}
    assert needed <= set(printed)
    opened = dataclasses.replace(asked(watched.command), duration_s=watched.run.duration_s)
    assert opened == watched.run.load()


def test_what_the_course_concludes_is_what_happened():
    by_number = {step.name[:2]: sessions(step.name) for step in STEPS}

    def found(names, of):
        return [of(by_number[n.split()[0]][n.split()[1]].summary) for n in names]

    stable = ["01 near", "02 waves", "06 implicit", "01 far", "06 one_frame_late"]
    assert found(stable, lambda s: bool(s["stable"])) == [True] * 3 + [False] * 2
    passive = ["02 waves", "04 filtered", "05 three", "07 l10", "07 strict", "10 far"]
    active = ["04 bare", "07 l40", "10 coarse"]
    verdicts = found([*passive, *active], lambda s: s["passivity"]["passive"])
    assert verdicts == [True] * 6 + [False] * 3
    ahead = {
        name: abs(steady["device"] - steady["avatar"])
        for name, steady in ((name, by_number["07"][name].steady()) for name in ("l40", "strict"))
    }
    assert ahead["strict"] < ahead["l40"] / 2.0
    lines = prediction_text.lines(by_number["10"]["far"].scenario, live=False)
    claim = "Stable at any constant delay, hands off, while all contacts touch"
    assert any(claim in line for line in lines)
    assert claim in (FOLDER / "10_what_remains.md").read_text("utf-8")


@pytest.mark.parametrize(
    "run", [Run("wall", HUM), Run("three_users", {**PLAIN, "link.delay_s": 0.1})], ids=str
)
def test_what_the_page_is_said_to_show_otherwise_is_green(run):
    assert watch(Watched(run))[1] == ["good"]


def test_a_wrong_number_is_found():
    numbers = read(FOLDER)
    numbers["02_waves"]["force"] *= 1.02
    page = page_of(STEPS[1])
    assert len(other_numbers(page, pages(numbers)["02_waves.md"])) == 1
    assert (FOLDER / NUMBERS).stat().st_size < 10_000
    assert sum(file.stat().st_size for file in FOLDER.rglob("*.*")) < 1_000_000
