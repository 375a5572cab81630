# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop clock, on an invented clock: no real time is judged here."""

import ctypes
import errno
import itertools
import os
import subprocess
import sys
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_core.runtime import pacing
from pmwvc_core.runtime.pacing import Pacer, Tick, hold_memory, request_real_time, sleep_until

MS = 1_000_000


class InventedClock:
    """A clock that only moves when somebody sleeps or works, and oversleeps as it is told."""

    def __init__(self, now_ns: int = 0) -> None:
        self.now_ns = now_ns
        self.oversleep_ns = 0

    def __call__(self) -> int:
        return self.now_ns

    def sleep_until(self, deadline_ns: int) -> None:
        self.now_ns = max(self.now_ns, deadline_ns) + self.oversleep_ns

    def work(self, duration_ns: int) -> None:
        self.now_ns += duration_ns


def pacer_on(clock: InventedClock, **settings: int) -> Pacer:
    settings = {"period_ns": MS} | settings
    return Pacer(**settings, clock=clock, sleep=clock.sleep_until)


@pytest.mark.parametrize(
    ("now_ns", "phase_ns", "due_ns"),
    [
        (7_300_000, 0, 8 * MS),
        (7 * MS, 0, 8 * MS),
        (7 * MS, 250_000, 7_250_000),
        (7 * MS, -100_000, 7_900_000),
    ],
)
def test_first_deadline_is_the_next_point_of_the_grid(now_ns, phase_ns, due_ns):
    tick = pacer_on(InventedClock(now_ns), phase_ns=phase_ns).wait()
    assert tick == Tick(due_ns // MS, due_ns, due_ns, 0, 0)


def test_another_period_goes_on_with_the_first_point_of_its_grid() -> None:
    pacer = pacer_on(InventedClock(), period_ns=8 * MS, phase_ns=2 * MS)
    ticks = [pacer.wait() for _ in range(4)]
    for period_ms, count in ((20, 3), (5, 3), (8, 2)):
        pacer.retime(period_ms * MS)
        ticks += [pacer.wait() for _ in range(count)]
    dues_ms = [tick.due_ns // MS for tick in ticks]
    assert dues_ms == [2, 10, 18, 26, 42, 62, 82, 87, 92, 97, 98, 106]
    assert not any(tick.skipped for tick in ticks)


def test_late_loop_runs_every_tick_half_a_period_apart_until_it_is_back() -> None:
    clock = InventedClock()
    pacer = pacer_on(clock)
    pacer.wait()
    clock.work(3 * MS)
    ticks = [pacer.wait() for _ in range(6)]
    assert [t.grid for t in ticks] == [2, 3, 4, 5, 6, 7]
    assert [t.woke_ns for t in ticks] == [4 * MS, 4_500_000, 5 * MS, 5_500_000, 6 * MS, 7 * MS]
    assert [t.lateness_ns for t in ticks] == [2 * MS, 1_500_000, MS, 500_000, 0, 0]
    assert not any(t.skipped for t in ticks)


@pytest.mark.parametrize(
    ("period_ms", "woke_ns", "tick"),
    [
        (1, 7 * MS, Tick(2, 2 * MS, 7 * MS, 5 * MS, 0)),  # made up for
        (1, 7 * MS + 1, Tick(7, 7 * MS, 7 * MS + 1, 1, 5)),  # skipped and counted
        (1, 42 * MS + 300_000, Tick(42, 42 * MS, 42 * MS + 300_000, 300_000, 40)),
        (100, 204 * MS, Tick(2, 200 * MS, 204 * MS, 4 * MS, 0)),  # no whole period to skip
    ],
)
@pytest.mark.parametrize("asleep", [False, True])
def test_lateness_beyond_the_recovery_limit_skips_whole_periods(period_ms, woke_ns, tick, asleep):
    """Whether the loop was busy or was stopped while asleep."""
    clock = InventedClock()
    pacer = pacer_on(clock, period_ns=period_ms * MS, recover_ns=5 * MS)
    first = pacer.wait()
    if asleep:
        clock.oversleep_ns = woke_ns - (first.due_ns + period_ms * MS)
    else:
        clock.now_ns = woke_ns
    assert pacer.wait() == tick


@given(
    period_ns=st.integers(1, 5 * MS),
    phase_ns=st.integers(-5 * MS, 5 * MS),
    recover_ns=st.integers(0, 30 * MS),
    loads=st.lists(
        st.tuples(st.integers(0, 60 * MS), st.integers(0, 2 * MS)), min_size=1, max_size=60
    ),
)
def test_every_deadline_is_either_run_or_counted(
    period_ns: int, phase_ns: int, recover_ns: int, loads: list[tuple[int, int]]
) -> None:
    clock = InventedClock(3 * MS)
    pacer = pacer_on(clock, period_ns=period_ns, phase_ns=phase_ns, recover_ns=recover_ns)
    ticks = []
    for work_ns, clock.oversleep_ns in loads:
        ticks.append(pacer.wait())
        clock.work(work_ns)
    assert all((t.due_ns - phase_ns) % period_ns == 0 for t in ticks)
    assert all(t.grid == t.due_ns // period_ns for t in ticks)
    assert all(t.woke_ns - t.due_ns == t.lateness_ns >= 0 for t in ticks)
    assert all(t.lateness_ns <= max(recover_ns, period_ns - 1) for t in ticks)
    for before, after in itertools.pairwise(ticks):
        assert after.grid - before.grid == 1 + after.skipped
        assert 2 * (after.woke_ns - before.woke_ns) >= period_ns


def test_ticks_end_when_stop_is_set_and_not_after_the_sleep_in_which_it_is() -> None:
    clock, stop = InventedClock(), threading.Event()

    def sleep(deadline_ns: int) -> None:
        clock.sleep_until(deadline_ns)
        if deadline_ns == 6 * MS:
            stop.set()

    assert [t.grid for t in Pacer(MS, clock=clock, sleep=sleep).ticks(stop)] == [1, 2, 3, 4, 5]


def test_sleep_reaches_its_deadline_and_ignores_a_past_one() -> None:
    deadline = time.monotonic_ns() + MS
    sleep_until(deadline)
    assert time.monotonic_ns() >= deadline
    sleep_until(deadline)
    sleep_until(-1)


def test_refusals_are_reported_with_reason_and_way_out(monkeypatch: pytest.MonkeyPatch) -> None:
    class Unprivileged:
        @staticmethod
        def mlockall(flags: int) -> int:
            ctypes.set_errno(errno.ENOMEM)
            return -1

        @staticmethod
        def prctl(*_: object) -> int:
            return 0

    def forbid(*_: object) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(pacing, "_libc", Unprivileged)
    monkeypatch.setattr(os, "sched_setscheduler", forbid)
    monkeypatch.setattr(os, "listdir", lambda _: ["1"])  # one thread that is not Python's
    monkeypatch.setattr("gc.freeze", lambda: None)
    assert pacing.granted_words(hold_memory() | request_real_time(20)) == (
        "memory lock refused (Cannot allocate memory; raise the user's memlock limit); "
        "frozen garbage collector granted; timer slack 1 ns granted; "
        "SCHED_FIFO 20 refused (Operation not permitted; raise the user's rtprio limit); "
        "SCHED_FIFO of the middleware refused "
        "(Operation not permitted; raise the user's rtprio limit)"
    )


def test_memory_to_come_is_locked_only_where_no_limit_can_make_it_fail(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    class Granting:
        prctl = staticmethod(lambda *_: 0)
        mlockall = staticmethod(lambda flags: asked.append(flags))

    monkeypatch.setattr(pacing, "_libc", Granting)
    monkeypatch.setattr(os, "sched_setscheduler", lambda *_: None)
    monkeypatch.setattr("gc.freeze", lambda: None)
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    for limit in (64 * 2**20, pacing.resource.RLIM_INFINITY):
        monkeypatch.setattr(pacing.resource, "getrlimit", lambda _, limit=limit: (limit, limit))
        assert not any(hold_memory().values())
    assert asked == [1 | 4, 1 | 2 | 4]


def test_memory_that_nothing_has_touched_is_not_held() -> None:
    """Stacks of 8 MB a thread, libraries: most of what a process maps it never uses."""
    code = (
        "import mmap, resource\n"
        "from pmwvc_core.runtime.pacing import hold_memory\n"
        "resident = lambda: int(open('/proc/self/statm').read().split()[1]) * mmap.PAGESIZE\n"
        "unused, used = mmap.mmap(-1, 1 << 26), mmap.mmap(-1, 1 << 24)\n"
        "before = resident()\n"
        "assert not any(hold_memory().values())\n"
        "held = resident()\n"
        "used[:] = bytes(1 << 24)\n"
        "print(held - before, resident() - held)\n"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    if "memory lock" in result.stderr:
        pytest.skip("no memory may be locked here")
    more, touched = map(int, result.stdout.split())
    assert more < 1 << 24 <= touched + (1 << 20)
