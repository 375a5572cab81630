#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Timings as ratios measured in one run: each number stands beside a reference taken at the same
time.

``make bench`` prints a table and writes ``bench.json`` into the current folder's ``sessions/``.
Nothing here passes or fails: a machine that is shared or slow shows in the reference as well.
"""

import argparse
import json
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from pmwvc_analysis.maps.maps import Grid, MapAxis, compute
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.replay.run import replay
from pmwvc_analysis.session_files import finish
from pmwvc_bringup.scenarios import load
from pmwvc_core.runtime.pacing import Pacer, hold_memory, request_real_time
from pmwvc_core.simulation.session import simulate

sys.path.insert(0, str(Path(__file__).parents[1]))
from relay import bench_relay

sys.path.insert(0, str(Path(__file__).parents[1]))
from controllers import bench_controllers
from frames import bench_frames
from page import bench_page
from support.map_points import point

ROOT = Path(__file__).resolve().parents[2]


def bare_loop(duration_s, queue):
    """Run a loop that only keeps deadlines; report how late it woke [us]."""
    hold_memory()
    request_real_time(20)
    pacer = Pacer(1_000_000)
    late = [pacer.wait().lateness_ns * 1e-3 for _ in range(int(duration_s * 1000))]
    queue.put((float(np.median(late)), float(np.percentile(late, 99))))


def live(duration_s, delay_s, folder):
    """Run a recorded two-user session with a bare loop beside it."""
    queue = multiprocessing.Queue()
    beside = multiprocessing.Process(target=bare_loop, args=(duration_s * 0.7, queue))
    command = [
        str(ROOT / "pmwvc"), "run", "carry_16ms", "--json", "--out", str(folder),
        "--duration", str(duration_s), "--set", f"link.delay_s={delay_s}",
    ]  # fmt: skip
    session = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    beside.start()
    output, _ = session.communicate(timeout=duration_s + 120)
    bare = queue.get(timeout=60)
    beside.join()
    return json.loads(output), bare


def relay_error_ms(folder):
    """Return the emulator's median and 99th percentile |delay - delay asked for| [ms]."""
    traces = read_session(folder)
    errors = np.concatenate(
        [(f.time_out_ns - f.time_due_ns)[f.time_out_ns > 0] * 1e-6 for f in traces.fates.values()]
    )
    return float(np.median(np.abs(errors))), float(np.percentile(np.abs(errors), 99))


def ratio(what, measured, reference, unit):
    """Return a row of the table."""
    return what, f"{measured:.3g} {unit}", f"{reference:.3g} {unit}", f"{measured / reference:.2f}"


def timed(work, times=1):
    """Return how long a call takes, the shortest of several [s]."""
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


def bench_loops(duration_s, rows, numbers):
    """Loop lateness and compute time beside a bare loop; relay error at several delays."""
    for delay_s in (0.0, 0.008, 0.016, 0.024):
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "session"
            summary, (bare_p50, bare_p99) = live(duration_s, delay_s, folder)
            p50, p99 = relay_error_ms(folder)
        late = statistics.median(u["lateness_us"]["p50"] for u in summary["users"])
        late99 = statistics.median(u["lateness_us"]["p99"] for u in summary["users"])
        compute = statistics.median(u["compute_us"]["p50"] for u in summary["users"])
        name = f"{delay_s * 1e3:.0f} ms"
        rows += [
            ratio(f"1 kHz loop, lateness p50, {name}", late, bare_p50, "us"),
            ratio(f"1 kHz loop, lateness p99, {name}", late99, bare_p99, "us"),
            ratio(f"1 kHz loop, compute p50, {name}", compute, 1000.0, "us"),
            ratio(f"relay, late p50, {name}", p50, 1.0, "ms"),
            ratio(f"relay, late p99, {name}", p99, 1.0, "ms"),
        ]
        numbers[f"live_{delay_s * 1e3:.0f}ms"] = {
            "lateness_us": late, "bare_lateness_us": bare_p50, "compute_us": compute,
            "relay_error_ms": p50, "relay_error_p99_ms": p99,
        }  # fmt: skip


def bench_simulation(rows, numbers, runs):
    """Simulation speed: one session, and many side by side."""
    scenario = load("carry_16ms", duration_s=10.0)
    single = timed(lambda: simulate([scenario]), times=5)
    plain = timed(lambda: simulate([replace(scenario, channel="plain")]), times=5)
    varied = [
        replace(
            scenario,
            users=tuple(
                replace(u, contact=replace(u.contact, contact_stiffness=100.0 + i))
                for u in scenario.users
            ),
        )
        for i in range(runs)
    ]
    batched = timed(lambda: simulate(varied, keep=lambda traces, _: traces.duration_s))
    rows += [
        ratio("session of 10 s against its simulation", 10.0, single, "s"),
        ratio("the same session on the strict channel against the plain one", single, plain, "s"),
        ratio(f"{runs} one by one against batched", runs * single, batched, "s"),
    ]
    numbers["simulation"] = {
        "times_real_time": 10 / single, "strict_against_plain": single / plain,
        "batched_speed_up": runs * single / batched, "runs": runs,
    }  # fmt: skip


def bench_map(rows, numbers):
    """A stability map of 100 x 100 points, as batches and point by point (every tenth row)."""
    grid = Grid(
        load("carry_16ms", settings_texts=["server.coupling=one_frame_late"]),
        MapAxis("server.contact_stiffness", tuple(np.linspace(10.0, 3000.0, 100).tolist())),
        MapAxis("server.contact_damping", tuple(np.linspace(0.0, 20.0, 100).tolist())),
    )
    batched = timed(lambda: compute(grid))
    plain = 10.0 * timed(
        lambda: [point(grid, row, place) for row in range(0, 100, 10) for place in range(100)]
    )
    rows.append(ratio("map of 100 x 100: point by point against batched", plain, batched, "s"))
    numbers["map"] = {"seconds": batched, "batched_speed_up": plain / batched}


def bench_replay(rows, numbers):
    """Replay speed, one session of two users without figures, beside real time."""
    scenario = load("carry_16ms", duration_s=10.0)
    traces = simulate([scenario])[0]
    seconds = timed(lambda: replay(traces, scenario, scenario), times=5)
    rows.append(ratio("session of 10 s against its replay", 10.0, seconds, "s"))
    numbers["replay"] = {"times_real_time": 10 / seconds}


def bench_load(duration_s, rows, numbers):
    """The emulator under load: packets that it lost, and the delay that it added."""
    found = numbers["relay_load"] = bench_relay(duration_s)
    sent, out = found["sent"], found["given_out"]
    rows += [
        ratio("relay, 4 links of 1 kHz and 200 bytes, packets out against sent", out, sent, ""),
        ratio("relay, same, late p50", found["error_p50_ms"], 0.2, "ms"),
        ratio("relay, same, late p99", found["error_p99_ms"], 1.0, "ms"),
    ]


def bench_report(duration_s, rows, numbers):
    """Report time against session length."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "session"
        live(duration_s, 0.016, folder)
        seconds = timed(lambda: finish(folder))
    rows.append(ratio("session against its report", duration_s, seconds, "s"))
    numbers["report"] = {"seconds": seconds, "session_s": duration_s}


def main():
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=10.0, help="length of each session [s]")
    parser.add_argument("--runs", type=int, default=1000, help="batched simulations")
    options = parser.parse_args()
    rows, numbers = [], {"cpus": os.cpu_count(), "python": sys.version.split()[0]}
    controllers, numbers["controllers"] = bench_controllers()
    bench_map(rows, numbers)
    bench_simulation(rows, numbers, options.runs)
    bench_replay(rows, numbers)
    bench_loops(options.duration, rows, numbers)
    bench_load(options.duration, rows, numbers)
    bench_report(options.duration, rows, numbers)
    pages, numbers["page"] = bench_page()
    frames, numbers["frames"] = bench_frames()
    table = Table("what", "measured", "reference in this run", "ratio")
    for row in rows:
        table.add_row(*row)
    Console().print(controllers, table, pages, frames)
    place = Path("sessions")
    place.mkdir(exist_ok=True)
    (place / "bench.json").write_text(json.dumps(numbers, indent=1) + "\n")


if __name__ == "__main__":
    main()
