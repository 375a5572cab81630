# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of a comparison's folder, read again."""

import json
from pathlib import Path
from typing import Any

from pmwvc_analysis.compare.files import JSON
from pmwvc_analysis.compare.measures import Entry, measured
from pmwvc_analysis.recording.reader import read_scenario, read_session
from pmwvc_core.errors import RecordingError


def is_comparison(folder: Path) -> bool:
    """Tell whether a folder holds a comparison, and is not a session itself (as a replay is)."""
    return (folder / JSON).is_file() and not any(folder.glob("*.mcap"))


def read_comparison(folder: Path) -> dict[str, Any]:
    """Return what ``comparison.json`` holds.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    try:
        found: dict[str, Any] = json.loads((folder / JSON).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise RecordingError(f"{folder / JSON} cannot be read: {error}") from None
    if not isinstance(found, dict) or "sessions" not in found:
        raise RecordingError(f"{folder / JSON} is no comparison: it holds no sessions")
    return found


def session_folders(folder: Path) -> list[Path]:
    """Return the folders of the sessions compared."""
    return [folder / str(session["folder"]) for session in read_comparison(folder)["sessions"]]


def read_entries(folder: Path) -> list[Entry]:
    """Return the sessions of a comparison, read and measured anew."""
    entries = []
    for session in read_comparison(folder)["sessions"]:
        path = folder / str(session["folder"])
        scenario = read_scenario(path)
        if scenario is None:
            raise RecordingError(f"{path} holds no scenario.yaml")
        entry = Entry(
            str(session["label"]),
            dict(session["settings"]),
            read_session(path),
            scenario,
            str(session["folder"]),
        )
        entries.append(measured(entry))
    return entries
