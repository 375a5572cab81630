# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The events of a live session that its runner sees, for the report and on the terminal."""

import json
import time
from pathlib import Path

from rich.console import Console

from pmwvc_bringup.session.processes import Child

STOPPED = "recorder: recording stopped"  # begin of the recorder's line when its disk is full


class Notes:
    """The events noted so far."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._events: list[dict[str, object]] = []

    def note(self, who: str, kind: str, what: str, **more: object) -> None:
        """Note an event of now."""
        event = {"time_ns": time.time_ns(), "who": who, "kind": kind, "what": what, **more}
        self._events.append(event)

    def _noted(self, what: str) -> bool:
        return any(event["what"] == what for event in self._events)

    def ended(self, child: Child) -> None:
        """Note the end of a node."""
        what = str(child).removeprefix(f"{child.name} ")
        self.note(child.name, "ended", what, code=child.code, signal=child.signal)
        self._console.print(f"{child}; its log: {child.log}")

    def recording_stopped(self, recorder: Child) -> list[str]:
        """Note, once, that the recorder has stopped recording, and return it as a text."""
        lines = recorder.log_tail().splitlines()
        stopped = next((line for line in lines if line.startswith(STOPPED)), "")
        if not stopped or self._noted(what := stopped.removeprefix("recorder: ")):
            return []
        self.note("recorder", "recording", what)
        self._console.print(stopped, markup=False)
        return ["recording stopped"]

    def stranger(self, topic: str, what: str) -> list[str]:
        """Note, once, publishers that do not belong to the session; return them as a text."""
        if self._noted(what):
            return []
        self.note(topic, "stranger", what)
        self._console.print(f"Warning: {what}", markup=False)
        return [what]

    def write(self, folder: Path) -> None:
        """Write ``events.json``."""
        try:
            text = json.dumps(self._events, indent=2) + "\n"
            (folder / "events.json").write_text(text, "utf-8")
        except OSError as error:
            self._console.print(f"events.json is not written: {error.strerror or error}")
