# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults that the tests of the project try: each a group of them, run here."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from faults.fault import Fault, Outcome

ROOT = Path(__file__).resolve().parents[2]
LIMIT_S = 550


def tests(*words: str) -> Callable[[], Outcome]:
    """Return the attempt that runs tests, by the words of pytest."""

    def attempt() -> Outcome:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words]
        result = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT_S, check=False
        )
        found = dict(
            (word, int(count))
            for count, word in re.findall(r"(\d+) (passed|failed|skipped|error)", result.stdout)
        )
        files = ", ".join(sorted({Path(w.split("::")[0]).name for w in words if ".py" in w}))
        counts = ", ".join(f"{count} {word}" for word, count in found.items())
        return Outcome(result.returncode == 0, f"{files}: {counts or 'none ran'}")

    return attempt


U, P, LIVE = "test/unit/", "test/property/", "test/integration/"
GROUPS = (
    Fault(
        "F07",
        "NaN, infinities and out-of-range numbers in every field of a packet",
        "refused and counted, output unchanged",
        tests(f"{U}test_receiver.py", f"{P}test_receiver.py"),
    ),
    Fault(
        "F08c",
        "stale packets, packets of an old session, replays, floods",
        "refused and counted",
        tests(f"{U}test_admission.py"),
    ),
    Fault(
        "F09b",
        "any flipped bit, a truncated packet",
        "all detected",
        tests(f"{U}test_admission.py", f"{U}test_messages.py", "-k", "bit or cut or bytes"),
    ),
    Fault(
        "F10",
        "the wall clock jumps by hours (simulated in the process)",
        "forces and packets bit-identical",
        tests(f"{U}test_wall_clock.py"),
    ),
    Fault(
        "F11",
        "the sender's time repeats or goes backwards",
        "refused, no stall beyond 8 packets",
        tests(f"{U}test_receiver.py", "-k", "earlier or poisoned or late_packets or repeated"),
    ),
    Fault(
        "F12",
        "loops stall for 25 ms and longer",
        "no grip lost at 25 ms; beyond, the force returns without a step",
        tests(f"{U}test_stalls.py"),
    ),
    Fault(
        "F13",
        "the disk is full, at the start and while recording",
        "refused in one line, or reported at once; the recorder keeps running",
        tests(f"{LIVE}test_recorder.py", "-k", "disk"),
    ),
    Fault(
        "F14",
        "truncated recordings, damaged bytes",
        "intact data is read, damage is located",
        tests(f"{U}test_reader.py", f"{U}test_doctor.py", f"{U}test_writer.py"),
    ),
    Fault(
        "F16",
        "parameters of wrong type, range or combination, also at run time",
        "refused with the reason; nothing changes",
        tests(f"{U}test_runtime_changes.py", f"{U}test_safety_changes.py"),
    ),
    Fault(
        "F17",
        "arbitrary bytes, wrong lengths, messages of other programs",
        "no exception; counted and dropped",
        tests(f"{U}test_messages.py", f"{P}test_strangers.py"),
    ),
    Fault(
        "F18",
        "packets without the token, of another session, with a new checksum",
        "refused with the right reason",
        tests(f"{U}test_admission.py", "-k", "forged or session or token"),
    ),
    Fault(
        "F19",
        "10 000 joins and leaves",
        "no growth in objects or state",
        tests(f"{U}test_memberships.py"),
    ),
    Fault(
        "F20",
        "plug-in environments raise, return invalid values, generate energy",
        "contained and named; energy limited",
        tests(f"{U}test_black_box_server.py", f"{P}test_black_box_passivity.py"),
    ),
    Fault(
        "F21",
        "velocities beyond the limit, non-finite values",
        "fault state, damping",
        tests(f"{U}test_safety.py"),
    ),
    Fault(
        "F25",
        "a sender claims more energy than a legal device can supply",
        "counted up to the longest legal wave only",
        tests("test/property/test_strict_channel.py", "-k", "claims"),
    ),
    Fault(
        "F26",
        "the recorder is killed",
        "flushed data is readable; the others continue",
        tests(f"{LIVE}test_recorder.py", "-k", "killed"),
        live=True,
    ),
)
