# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The course: every number is what its sessions give, every command runs them."""

import re
import shlex
from pathlib import Path

import pytest
from support.simulated import judged, simulated

from course.first_half import HUM
from course.page import Watched, watch
from course.step import PLAIN, Run, Session
from course.watching import WATCHED
from course.written import NUMBERS, STEPS, pages, read
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_bringup import scenarios
from pmwvc_bringup.options import scenario_of
from pmwvc_bringup.parser import build_parser

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "course"


def sessions(step):
    found = {}
    for name, run in step.runs.items():
        scenario = run.load()
        found[name] = Session(scenario, simulated(scenario), judged(scenario))
    return found


def test_there_are_ten_steps_and_a_page_for_each():
    assert len(STEPS) == 10
    assert {page.name for page in FOLDER.glob("*.md")} == set(pages(read(FOLDER)))


@pytest.mark.parametrize("name", [step.name + ".md" for step in STEPS] + ["README.md"])
def test_a_page_is_what_its_template_and_the_numbers_give(name):
    page = (FOLDER / name).read_text("utf-8")
    assert page == pages(read(FOLDER))[name], "run make course"
    for target in re.findall(r"\]\(([^)#]+)", page):
        assert (FOLDER / target).exists(), target


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.name)
def test_the_numbers_of_a_step_are_those_of_its_sessions_and_of_the_page(step):
    watched = WATCHED[step.name]
    shown, levels = watch(watched)
    assert levels == [watched.before, watched.after][: 1 + bool(watched.settings)]
    found = step.numbers(sessions(step)) | shown
    assert found == pytest.approx(read(FOLDER)[step.name], rel=2e-2, abs=2e-4), "run make course"


def commands():
    for page in sorted(FOLDER.glob("*.md")):
        text = page.read_text("utf-8")
        yield from re.findall(r"^(?:    )?\./pmwvc (.*)$", text, re.MULTILINE)
        yield from re.findall(r"`\./pmwvc (.*?)`", text)


def test_every_command_is_one_and_names_a_session_that_loads():
    parser = build_parser()
    words = [shlex.split(command, comments=True) for command in commands()]
    assert len(words) > 35
    for each in words:
        arguments = parser.parse_args(each)
        if hasattr(arguments, "scenario"):
            scenario_of(arguments)
        elif arguments.command.name == "view":
            scenarios.load(arguments.what, settings_texts=arguments.settings)


def test_the_commands_of_a_step_are_the_sessions_of_its_numbers():
    parser = build_parser()
    for step in STEPS:
        page = (FOLDER / f"{step.name}.md").read_text("utf-8")
        for run in step.runs.values():
            shown_before = (step.name, run.scenario) == ("02_waves", "direct_16ms")
            assert run.command in page or shown_before
            words = shlex.split(run.command.removeprefix("./pmwvc "))
            assert scenario_of(parser.parse_args(words)) == run.load()


def test_what_the_course_concludes_is_what_happened():
    by_number = {step.name[:2]: sessions(step) for step in STEPS}

    def passive(number, name):
        return by_number[number][name].summary["passivity"]["passive"]

    assert (
        by_number["01"]["near"].summary["stable"] and not by_number["01"]["far"].summary["stable"]
    )
    assert passive("02", "waves") and by_number["02"]["waves"].summary["stable"]
    assert passive("04", "filtered") and passive("04", "bare") is False
    assert passive("05", "three")
    assert by_number["06"]["implicit"].summary["stable"]
    assert not by_number["06"]["one_frame_late"].summary["stable"]
    assert passive("07", "l10") and passive("07", "l40") is False
    assert passive("07", "strict")
    ahead = {
        name: abs(steady["device"] - steady["avatar"])
        for name, steady in ((name, by_number["07"][name].steady()) for name in ("l40", "strict"))
    }
    assert ahead["strict"] < ahead["l40"] / 2.0
    assert passive("10", "far") and passive("10", "coarse") is False
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
    numbers["02_waves"]["force"] *= 1.1
    assert pages(numbers)["02_waves.md"] != (FOLDER / "02_waves.md").read_text("utf-8")
    assert (FOLDER / NUMBERS).stat().st_size < 10_000
    assert sum(file.stat().st_size for file in FOLDER.rglob("*.*")) < 1_000_000
