# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The part of a step that people do on the live page, and the result in the page's session."""

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from course.step import MM, Numbers, Run
from pmwvc_view import SNAPSHOT_S, controls
from pmwvc_view.controls import Setting
from pmwvc_view.simulated import SimulatedSession

POLL_S = 0.2


@dataclass(frozen=True)
class Watched:
    """A session on the page, and the settings changed there.

    ``before`` and ``after`` are levels of the page's verdict: good, caution, bad, unknown;
    ``again``: the session is begun again after the change of a link, which acts at once.
    """

    run: Run
    settings: Mapping[str, Setting] = field(default_factory=dict)
    before: str = "good"
    after: str = "good"
    again: bool = False

    @property
    def command(self) -> str:
        """The command line that opens the page."""
        settings = [f"--set {name}={value}" for name, value in self.run.changes.items()]
        return " ".join(["./pmwvc view", self.run.scenario, *settings])

    @property
    def changes(self) -> str:
        """The settings in words, as the page labels them."""
        return " and ".join(
            f"*{controls.control_of(path).label}* to {_shown(path, value)}"
            for path, value in self.settings.items()
        )


def watch(watched: Watched) -> tuple[Numbers, list[str]]:
    """Return what is to be seen before and after the change, and the levels of the verdict.

    The session is the one that ``pmwvc view`` serves, with a clock that is advanced by hand.
    """
    now = [0.0]
    session = SimulatedSession(watched.run.load(), clock=lambda: now[0])
    numbers, levels = _watched("before", session, now, watched.run.duration_s)
    if watched.settings:
        values = dict(watched.settings)
        if all(controls.control_of(path).path.startswith("link.") for path in values):
            answers = [asyncio.run(session.set(*each)) for each in values.items()]
        else:
            answers = [session.restart(values)]
        if watched.again:
            answers.append(session.restart({}))
        refused = [answer.text for answer in answers if not answer.done]
        assert not refused, refused
        after, more = _watched("after", session, now, watched.run.duration_s)
        numbers, levels = numbers | after, levels + more
    return numbers, levels


def _watched(
    name: str, session: SimulatedSession, now: list[float], seconds: float
) -> tuple[Numbers, list[str]]:
    rows = []
    for _ in range(round(seconds / POLL_S)):
        now[0] += POLL_S
        rows += [snapshot.row for snapshot in session.poll()]
        text = session.news()["text"]
    where = session.layout.slices
    late = np.array(rows[-round(1.0 / SNAPSHOT_S) :])

    def of(column: str) -> np.ndarray:
        return np.asarray(late[:, where[f"user1.{column}"].start])

    ahead = np.abs(of("x_m") - of("x_s"))
    numbers = {
        f"page_{name}_swing": float(of("f_max").max() - of("f_min").min()),
        f"page_{name}_ahead_mm": float(ahead[-1]) * MM,
    }
    return numbers, [str(text["level"])]


def _shown(path: str, value: Setting) -> str:
    """Return a value as the page shows it."""
    if path == "link.loss":
        return f"{100 * float(value):g} %"
    if path.endswith("_s") and not isinstance(value, str):
        return f"{1e3 * float(value):g} ms"
    unit = {
        "server.contact_stiffness": " N/m",
        "server.object_mass": " kg",
        "master.impedance": " N s/m",
    }
    return f"{value if isinstance(value, str) else format(value, 'g')}{unit.get(path, '')}"
