# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The faults of plug-ins in a simulated session, by the metadata that the simulation keeps."""

from collections.abc import Iterator
from typing import Any

from pmwvc_analysis.events.event import Event, event
from pmwvc_core.plural import count
from pmwvc_core.traces import SessionTraces

REPLACED = ("environment", "coupling")  # by a damper, in the steps that failed
LINKS = "links"


def kept(traces: SessionTraces) -> dict[str, Any]:
    """Return the faults of a simulated session as metadata records of its recording."""
    return {name: traces.metadata[name] for name in (*REPLACED, LINKS) if name in traces.metadata}


def faults(traces: SessionTraces) -> Iterator[Event]:
    """Yield an event for whatever failed, with its count and the last reason."""
    for what in REPLACED:
        if fault := traces.metadata.get(what):
            steps = count(int(fault["contained_steps"]), "step")
            text = f"a damper replaced the {what} in {steps}: {fault['last_fault']}"
            yield event(None, "server", "environment", text)
    for link, text in traces.metadata.get(LINKS, {}).items():
        yield event(None, f"link {link}", "link", text)
