# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of a comparison: simulated as one batch, or run live one after the other."""

import dataclasses
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from pmwvc_analysis.compare import settings
from pmwvc_analysis.compare.measures import Entry, measured
from pmwvc_bringup.comparison.combinations import Combination
from pmwvc_bringup.scenarios import to_yaml
from pmwvc_core.errors import PmwvcError
from pmwvc_core.traces import SessionTraces


def folder_of(number: int, one: Combination) -> str:
    """Return the folder of a session below that of the comparison."""
    plain = re.sub(r"[^A-Za-z0-9_.=-]+", "_", one.label.replace(" = ", "="))[:60]
    return f"runs/{number:02d}-{plain}"


def tuned(chosen: Sequence[Combination], show: Callable[[float], None]) -> list[Combination]:
    """Return the combinations with the baselines of each tuned for its scenario."""
    found = []
    for number, one in enumerate(chosen):

        def part(ratio: float, *, before: int = number) -> None:
            show((before + ratio) / len(chosen))

        scenario, words = settings.tuned(one.scenario, part, given=one.given)
        found.append(dataclasses.replace(one, scenario=scenario, tuning=words))
    return found


def simulated(
    chosen: Sequence[Combination], folder: Path, show: Callable[[float], None]
) -> list[Entry]:
    """Simulate all, batched; write each as a session without pictures."""
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.session_files import write_summary
    from pmwvc_analysis.verdicts.verdicts import summary
    from pmwvc_core.simulation.session import simulate

    traces = simulate(
        [one.scenario for one in chosen],
        keep=lambda kept, _: kept,
        progress=lambda ratio: show(0.5 * ratio),
    )
    entries = []
    for number, (one, each) in enumerate(zip(chosen, traces, strict=True), start=1):
        below = folder_of(number, one)
        record_traces(folder / below, each, one.scenario)
        write_summary(folder / below, summary(each, one.scenario))
        entries.append(_entry(one, each, below))
        show(0.5 + 0.5 * number / len(chosen))
    return entries


def live(chosen: Sequence[Combination], folder: Path, console: Console) -> list[Entry]:
    """Run one session of nodes after the other, each by a runner of its own."""
    from pmwvc_analysis.recording.reader import read_session

    entries = []
    for number, one in enumerate(chosen, start=1):
        below = folder_of(number, one)
        console.print(f"{number} of {len(chosen)}: {one.label}", markup=False)
        with tempfile.TemporaryDirectory() as scratch:
            file = Path(scratch, "scenario.yaml")
            file.write_text(to_yaml(one.scenario), "utf-8")
            words = ["run", str(file), "--out", str(folder / below)]
            command = [sys.executable, "-m", "pmwvc_bringup.cli", *words]
            code = subprocess.run(command, check=False).returncode
        if code == 130:
            raise KeyboardInterrupt
        if code:
            raise PmwvcError(f"{one.label}: the session did not run (exit code {code}); see above")
        entries.append(_entry(one, read_session(folder / below), below))
    return entries


def _entry(one: Combination, traces: SessionTraces, below: str) -> Entry:
    return measured(Entry(one.label, one.settings, traces, one.scenario, below, one.tuning))
