# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The Python interface: simulate a scenario, change it, judge it, read and export a session.

It needs no ROS. A page of examples: ``docs/python.md``. Traces are those of
:mod:`pmwvc_core.traces`: arrays ``(tick, dof)`` in SI units.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pmwvc_analysis.export import export
from pmwvc_analysis.figures.figures import charts, write_all
from pmwvc_analysis.models.answer import answer
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_analysis.session_files import finish
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

__all__ = [
    "export", "figures", "names", "read", "record", "save", "scenario", "simulate", "stability",
    "verdict",
]  # fmt: skip


def names() -> list[str]:
    """Return the scenarios that come with the project."""
    return list(scenarios.known())


def scenario(
    source: str | Path | Scenario,
    changes: Mapping[str, object] | None = None,
    *,
    users: int | None = None,
    duration_s: float | None = None,
) -> Scenario:
    """Return a scenario, with parameters changed; ScenarioError lists every mistake.

    Parameters
    ----------
    source
        A name, a YAML file, or a scenario to change.
    changes
        Values by dotted name, as with ``--set`` of the command line: ``{"link.delay_s": 0.05}``.
    users, duration_s
        Number of users, 1 to 8; length [s].
    """
    if isinstance(source, Scenario):
        mapping, origin = source.to_dict(), source.name
    else:
        origin = str(source)
        mapping = scenarios.read(scenarios.find(origin))
    return parse_scenario(
        mapping, source=origin, overrides=changes, users=users, duration_s=duration_s
    )


def simulate(session: Scenario) -> SessionTraces:
    """Simulate a session in virtual time and return its signals."""
    return simulate_one(session)


def stability(session: Scenario) -> dict[str, Any]:
    """Return what the exact model says before any session (keys: ``pmwvc stability --help``).

    Raises
    ------
    NonlinearError
        If something is not linear; names it, and the nearest linear scenario where there is one.
    UnknownError
        If an answer needs too much work: long hyperperiods, many packets under way. Where it is
        only the largest stiffness, ``k_max_unknown`` says so. Both are ``ValueError``.
    """
    return answer(session, live=False)


def verdict(traces: SessionTraces, session: Scenario | None) -> dict[str, Any]:
    """Return the judgement of a session: the keys of ``summary.json`` (docs/file_format.md)."""
    return summary(traces, session)


def figures(folder: str | Path, traces: SessionTraces, session: Scenario | None) -> None:
    """Draw the figures of the report into a folder, as PNG and SVG."""
    write_all(charts(traces, session), traces, Path(folder))


def record(folder: str | Path, traces: SessionTraces, session: Scenario) -> None:
    """Write a session's ``session.mcap``, ``metadata.yaml``, ``scenario.yaml``; RecordingError."""
    record_traces(folder, traces, session)


def save(folder: str | Path, traces: SessionTraces, session: Scenario) -> dict[str, Any]:
    """Write a simulated session as ``pmwvc simulate`` does, report included; return its verdict.
    RecordingError where the folder cannot be written.
    """
    record(folder, traces, session)
    return finish(folder, scenario=session)


def read(folder: str | Path) -> tuple[SessionTraces, Scenario | None]:
    """Return a recorded session, live or simulated, and its scenario where the folder has one;
    RecordingError where there is no recording, or nothing of it can be read.
    """
    return read_session(folder), read_scenario(folder)
