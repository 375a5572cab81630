# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Timings of the live page: lateness of the force loops with nobody, one and four pages connected,
by turns in one session; the view's share of a core; from a pointer to the hand's target.
"""

import os
import statistics
import subprocess
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from rich.table import Table
from support.live_pages import Pointer, address_of

from pmwvc_analysis.recording.reader import read_session

ROOT = Path(__file__).resolve().parents[2]
PAGES = (0, 1, 4)


def cpu_s(pid):
    """Return the processor time that a process has used [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def view_pid(parent):
    """Return the process of the view that a session runner started."""
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
            command = (status.parent / "cmdline").read_text()
        except OSError:
            continue
        if fields[1] == str(parent) and "pmwvc_view.node" in command:
            return int(status.parent.name)
    raise RuntimeError("the session has no view")


def phase(address, pages, length_s):
    """Keep pages connected for a while, the first of which drags a handle."""
    stop = threading.Event()
    pointers = [Pointer(address, user="user1" if not n else None) for n in range(pages)]
    threads = [threading.Thread(target=each.run, args=(stop,)) for each in pointers]
    for thread in threads:
        thread.start()
    time.sleep(length_s)
    stop.set()
    for thread in threads:
        thread.join()
    return pointers


def bench_page(turns=3, length_s=5.0):
    """Return a table and the numbers behind it."""
    phases, used = [], {pages: [] for pages in PAGES}
    sent = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "session"
        session = subprocess.Popen(
            [ROOT / "pmwvc", "run", "live", "--view", "--no-browser", "--out", folder],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        try:
            address = address_of(session.stdout)
            pid = view_pid(session.pid)
            for turn in range(turns):
                for pages in PAGES[turn % len(PAGES) :] + PAGES[: turn % len(PAGES)]:
                    begin_ns, begin_s = time.time_ns(), cpu_s(pid)
                    for pointer in phase(address, pages, length_s):
                        sent |= pointer.sent_ns
                    used[pages].append((cpu_s(pid) - begin_s) / length_s)
                    phases.append((pages, begin_ns, time.time_ns()))
        finally:
            session.terminate()
            session.communicate(timeout=120)
        traces = read_session(folder)
    zero_ns = traces.metadata["zero_ns"]
    late = {pages: [] for pages in PAGES}
    for pages, begin_ns, end_ns in phases:
        begin_s, end_s = (begin_ns - zero_ns) * 1e-9 + 0.5, (end_ns - zero_ns) * 1e-9
        for user in traces.users:
            within = (user.time_s >= begin_s) & (user.time_s < end_s)
            late[pages].append(user.lateness_s[within] * 1e6)
    table = Table("pages", "lateness p50 [us]", "p99 [us]", "view, part of a core [%]")
    numbers = {}
    for pages in PAGES:
        every = np.concatenate(late[pages])
        p50, p99 = np.percentile(every, [50, 99])
        core = 100.0 * statistics.median(used[pages])
        table.add_row(str(pages), f"{p50:.1f}", f"{p99:.1f}", f"{core:.1f}")
        numbers[str(pages)] = {"lateness_us": p50, "lateness_p99_us": p99, "core_percent": core}
    targets = traces.targets["user1"]
    taken = [
        (at_s * 1e9 + zero_ns - sent[value]) * 1e-6
        for at_s, value in zip(targets.time_s, targets.position[:, 0].tolist(), strict=True)
        if value in sent
    ]
    p50, p95 = np.percentile(taken, [50, 95])
    table.caption = f"pointer to hand target: median {p50:.2f} ms, 95 % below {p95:.2f} ms"
    numbers["pointer_to_target_ms"] = {"p50": p50, "p95": p95, "count": len(taken)}
    return table, numbers
