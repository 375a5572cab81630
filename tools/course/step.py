# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A step of the course as a record: the sessions it runs, its numbers and its picture."""

import contextlib
import functools
import io
import json
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import pmwvc
from pmwvc_analysis.charts.chart import Chart, Curve
from pmwvc_bringup.cli import build_parser
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, UserTraces

Numbers = dict[str, float]
PLAIN = {"channel": "plain"}  # the channel of the equations; step 7 has the other one
MM, MJ = 1e3, 1e3


@dataclass(frozen=True)
class Run:
    """A session of a step: a scenario with changes, as on the command line."""

    scenario: str
    changes: Mapping[str, object] = field(default_factory=dict)
    duration_s: float = 8.0

    @property
    def command(self) -> str:
        """The command line that runs it."""
        return f"./pmwvc simulate {self.words}"

    @property
    def words(self) -> str:
        """Scenario and options."""
        settings = [f"--set {name}={value}" for name, value in self.changes.items()]
        return " ".join([self.scenario, f"--duration {self.duration_s:g}", *settings])

    def load(self) -> Scenario:
        """Return the scenario of the session."""
        return pmwvc.scenario(self.scenario, self.changes, duration_s=self.duration_s)


@dataclass(frozen=True)
class Question:
    """A command of a step that asks the model, and the numbers of its answer."""

    words: str
    numbers: Callable[[Any], Numbers]

    @property
    def command(self) -> str:
        """The command line that asks it."""
        return f"./pmwvc {self.words}"


def document(command: str, *options: str) -> Any:
    """Run a command line as printed, with further options; return its document."""
    words = shlex.split(command.removeprefix("./pmwvc "))
    arguments = build_parser().parse_args([*words, *options])
    with contextlib.redirect_stdout(io.StringIO()):
        found = arguments.command.run(arguments).document
    return json.loads(found) if isinstance(found, str) else found


@dataclass(frozen=True)
class Session:
    """A session that was run, and its verdict."""

    scenario: Scenario
    traces: SessionTraces
    summary: dict[str, Any]

    @property
    def user(self) -> UserTraces:
        """The first user."""
        return self.traces.users[0]

    def steady(self) -> Numbers:
        """Return force [N], device and avatar [mm] of the first user at the end."""
        user, server = self.user, self.traces.server
        assert server is not None
        late, late_steps = (t > self.traces.duration_s - 0.5 for t in (user.time_s, server.time_s))
        return {
            "force": float(np.mean(user.f_applied[late, 0])),
            "device": float(np.mean(user.x_m[late, 0])) * MM,
            "avatar": float(np.mean(server.x_s[0][late_steps, 0])) * MM,
        }

    def least_balance_mj(self) -> float:
        """Return the lowest energy balance of any user's port [mJ]."""
        ports = self.summary["passivity"]["ports"]
        found = [p["least_balance_j"] for p in ports if p["owner"] != "server"]
        return float(min(found)) * MJ

    def curve(self, label: str, signal: str, tint: str, *, width: float = 1.4) -> Curve:
        """Return a signal of the first user over time as a curve, every fourth tick."""
        values = getattr(self.user, signal)[::4, 0]
        return Curve(label, self.user.time_s[::4], values, tint, width=width)


def simulated(run: Run) -> Session:
    """Run a session and judge it; once, where two steps have the same."""
    return _session(run.load())


@functools.cache
def _session(scenario: Scenario) -> Session:
    traces = pmwvc.simulate(scenario)
    return Session(scenario, traces, pmwvc.verdict(traces, scenario))


@dataclass(frozen=True)
class Step:
    """One step of the course: ``runs`` by name, and what is computed of their sessions; questions
    to the model by name.
    """

    name: str
    title: str
    runs: Mapping[str, Run]
    numbers: Callable[[Mapping[str, Session]], Numbers]
    chart: Callable[[Mapping[str, Session]], Chart]
    questions: Mapping[str, Question] = field(default_factory=dict)

    def answers(self) -> Numbers:
        """Return the numbers of the answers to its questions."""
        found = [each.numbers(document(each.command)) for each in self.questions.values()]
        return {name: value for numbers in found for name, value in numbers.items()}
