# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The checks of a recording: the file is whole, nothing is missing, the physics agrees.

Three kinds of findings: the file (records and checksums of the MCAP, metadata), what is missing
(per topic and publisher), and physics (numbers are finite, ports obey F = sqrt(b/2) (u - v),
running sums agree with the signals they sum).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pmwvc_analysis.recording.content import Content, read_content
from pmwvc_analysis.recording.reader import read_scenario, session_of
from pmwvc_analysis.recording.topics import HAND, SCENE, relayed
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_core.errors import PmwvcError
from pmwvc_core.traces import SessionTraces

OK, WARNING, PROBLEM = "ok", "warning", "problem"
# Topics that carry nothing where nothing was changed, no hand is remote, the ends are programs
# that do not report what they received, and the environment says nothing of itself.
QUIET = ("/parameter_events", *HAND.values(), "/reception", SCENE)


@dataclass(frozen=True)
class Checked:
    """The result of one check. Of a recording a warning is a declared loss, a problem damage; of
    a machine a warning is that a session runs, less well.
    """

    check: str
    status: str
    text: str
    remedy: str = ""

    def line(self) -> str:
        """Return the finding as a person reads it."""
        remedy = f"\n{'':21}-> {self.remedy}" if self.remedy else ""
        return f"{self.status:8} {self.check:11} {self.text}{remedy}"


def check_recording(folder: str | Path) -> list[Checked]:
    """Run every check on a session folder (or a bare ``.mcap`` file)."""
    folder = Path(folder)
    try:
        content = read_content(folder)
    except PmwvcError as error:
        return [Checked("file", PROBLEM, str(error))]
    findings = list(_structure(folder, content))
    try:
        traces = session_of(content, folder)
        findings += _losses(content, traces)
        wrong = inconsistencies(traces, read_scenario(folder))
        findings += [Checked("physics", PROBLEM, each) for each in wrong]
        if not wrong:
            findings.append(Checked("physics", OK, "ports, powers and running sums agree"))
    except PmwvcError as error:
        findings.append(Checked("content", PROBLEM, str(error)))
    return findings


def exit_code(findings: list[Checked]) -> int:
    """Return 0 for complete, 2 for complete but for declared losses, 3 for damaged."""
    statuses = {finding.status for finding in findings}
    return 3 if PROBLEM in statuses else 2 if WARNING in statuses else 0


def _structure(folder: Path, content: Content) -> Iterator[Checked]:
    for name, file in content.files.items():
        if file.whole:
            size = f"{file.messages} messages in {file.chunks} chunks"
            yield Checked("file", OK, f"{name} is whole: {size}")
        yield from (Checked("file", PROBLEM, f"{name}: {text}") for text in file.problems)
    if folder.is_dir() and not (folder / "metadata.yaml").is_file():
        yield Checked("file", WARNING, "no metadata.yaml: rosbag2 cannot open the folder")


def _losses(content: Content, traces: SessionTraces) -> list[Checked]:
    """Name what is missing per topic and publisher; what an emulated link lost is not missing."""
    texts = []
    for topic, count in traces.counts.items():
        if count["missing"] and (link := relayed(topic)) in traces.fates:
            texts.append(f"{topic}: {count['missing']} packets that {link} delivered")
        elif count["missing"]:
            texts += [
                f"{topic}: {missing} of {missing + seen} missing (publisher {name})"
                for name, (missing, seen) in content.gaps(topic).items()
                if missing
            ]
        if not count["messages"] and not topic.endswith(QUIET):
            texts.append(f"{topic}: nothing recorded")
    strange = (e for e in traces.events if e["who"] == "recorder" or e.get("kind") == "stranger")
    texts += [str(event["what"]) for event in strange]
    complete = "nothing is missing: the numbers of every publisher are complete"
    found = [Checked("missing", WARNING, text) for text in texts]
    return found or [Checked("missing", OK, complete)]
