# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The list of events of a session: every change of state of safety, contact and membership.

One list for live, simulated and replayed sessions: what reader and session runner noted, and what
the traces show. An event is ``{"time_s": float | None, "who": str, "kind": str, "what": str}``;
kinds: docs/file_format.md.
"""

from collections.abc import Iterator

from pmwvc_analysis.events import grips, nodes
from pmwvc_analysis.events.nodes import Event, event
from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces.stages import changes_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_core.words import count


def complete(traces: SessionTraces, scenario: Scenario | None) -> list[Event]:
    """Return what was noted of a session and what its traces show, in the order of time, events
    without a time first.
    """
    found = [*traces.events, *_derived(traces, scenario)]
    return sorted(found, key=lambda each: (each["time_s"] is not None, each["time_s"] or 0.0))


def _derived(traces: SessionTraces, scenario: Scenario | None) -> Iterator[Event]:
    for user in traces.users:
        yield from nodes.of_master(user, scenario)
    if (server := traces.server) is not None:
        yield from nodes.of_server(server, traces, scenario)
        yield from grips.events(server, scenario, server.scene)
    yield from faults(traces)
    if scenario is not None and not traces.live:
        for change in changes_of(traces, scenario):
            if change.time_s < traces.duration_s:
                yield event(change.time_s, "scenario", "parameter", f"set {change.words()}")
    for hole in holes.holes(traces):
        unit = "steps" if hole.owner == holes.SERVER else "blocks"
        times = f"from {hole.start_s:.3f} to {hole.end_s:.3f} s ({hole.missing} {unit})"
        what = f"trace of {hole.owner} not recorded {times}"
        yield event(hole.start_s, "recorder", "recording", what)


def faults(traces: SessionTraces) -> Iterator[Event]:
    """Yield an event for whatever failed, with its count and the last reason."""
    for what in ("environment", "coupling"):  # replaced in the steps that failed
        if fault := traces.metadata.get(what):
            steps = count(int(fault["contained_steps"]), "step")
            text = f"the {what} failed in {steps}: {fault['last_fault']}"
            yield event(None, "server", "environment", text)
    if traces.live and traces.server is not None and (late := traces.server.replaced)[1]:
        text = f"environment or coupling failed in {count(late[1], 'step')}"
        yield event(late[0], "server", "environment", f"{text}: the reason is in its log")
    for link, text in traces.metadata.get("links", {}).items():
        yield event(None, f"link {link}", "link", text)
