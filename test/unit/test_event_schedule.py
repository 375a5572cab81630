# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The order of events in virtual time, on the grid and as a recorded session ran."""

import numpy as np

from pmwvc_core.simulation.event_schedule import EventKind, LoopTimes, Steps, events, frame_events

MS = 1_000_000


def answers(loop):
    """Return tick and time of every answer taken."""
    return [found.tolist() for found in frame_events(loop, loop.answer, ticks=16, tick_ns=MS)]


def listed(loops, *, steps=None, ticks=16, server_ticks=0):
    steps = steps or Steps.on_grid(every=8, first=server_ticks, ticks=ticks, tick_ns=MS)
    return list(events(loops, steps, ticks=ticks, tick_ns=MS))


def test_the_order_of_a_frame_is_send_serve_tick():
    first = [row for row in listed([LoopTimes(8), LoopTimes(8)]) if row[0] == 0]
    assert [(EventKind(kind).name, who) for _, kind, who, _ in first] == [
        ("SEND", 0),
        ("SEND", 1),
        ("SERVE", 0),
        ("TICK", 0),
        ("TICK", 1),
    ]


def test_every_tick_runs_once_and_frames_send_once():
    rows = listed([LoopTimes(8), LoopTimes(4, first=3)])
    ticks = [(who, tick) for _, kind, who, tick in rows if kind == EventKind.TICK]
    assert sorted(ticks) == [(0, k) for k in range(16)] + [(1, k) for k in range(3, 16)]
    assert [t for _, kind, who, t in rows if kind == EventKind.SEND and who == 1] == [3, 7, 11, 15]


def test_live_phases_put_the_step_after_two_ticks_and_the_answer_after_four():
    rows = listed([LoopTimes(8, answer=4)], server_ticks=2)
    assert [row[0] for row in rows if row[1] == EventKind.SERVE] == [2 * MS, 10 * MS]
    assert answers(LoopTimes(8, answer=4)) == [[4, 12], [4 * MS, 12 * MS]]


def test_events_come_in_the_order_in_which_loops_really_ran():
    ran = np.arange(16) * MS
    ran[2:5] = [int(5.2 * MS), int(5.7 * MS), int(6.2 * MS)]  # late, and catching up
    ran[5:8] = [int(6.7 * MS), int(7.2 * MS), int(7.7 * MS)]
    steps = Steps(np.array([2, 10]), np.array([2 * MS, 10 * MS + 300]))
    rows = listed([LoopTimes(8, answer=4, ran_ns=ran)], steps=steps)
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    order = [(EventKind(kind).name, tick) for time, kind, _, tick in rows if time < 6 * MS]
    assert order.index(("SERVE", 0)) < order.index(("TICK", 2))
    assert answers(LoopTimes(8, answer=4, ran_ns=ran))[1][0] == ran[4]


def test_a_missed_tick_passes_when_the_loop_runs_again():
    ran = np.arange(16) * MS
    ran[6:10] = -1  # the end of one frame and the start of the next
    rows = listed([LoopTimes(8, answer=4, ran_ns=ran)])
    passed = [(time, tick) for time, kind, _, tick in rows if kind == EventKind.PASS]
    assert passed == [(10 * MS, k) for k in range(6, 10)]
    assert [t for _, kind, _, t in rows if kind == EventKind.SEND] == [0, 10]
    at_ten = [
        EventKind(kind).name
        for time, kind, *_ in rows
        if time == 10 * MS and kind != EventKind.SERVE
    ]
    assert at_ten == [*["PASS"] * 4, "SEND", "TICK"]


def test_ticks_before_the_first_and_after_the_last_are_not_missed():
    ran = np.full(16, -1)
    ran[3:12] = np.arange(3, 12) * MS
    rows = listed([LoopTimes(8, first=2, ran_ns=ran)])
    assert not [row for row in rows if row[1] == EventKind.PASS]
