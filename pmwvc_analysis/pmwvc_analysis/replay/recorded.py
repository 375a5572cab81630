# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions that a recorded session sets for its replay: hands, network, times of the loops.

**The hand.** ``operator``: the hand of the scenario, as a model, once more. It is the same person
with the same intention, and reacts to what the changed system makes it feel; physically this is
what a change of parameters means. ``force``: the recorded force, tick for tick. It shows what the
same push would have done, but a force alone holds nothing in place: where the replayed device is
not where the recorded one was, nothing brings it back, and the two drift apart. So the operator is
the default where the session had one (a simulated device); of a real device with a force sensor
only the force is known. A remote hand is an operator whose targets are the recorded ones.

**Parameters.** What changed in flight changes again at its time, but for what was set for the
replay: at the server with the step that took it over, at a master within a frame.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from pmwvc_analysis.replay.arrivals import sent_and_used, tick_numbers
from pmwvc_analysis.replay.loop_times import LoopTimes
from pmwvc_analysis.replay.network import links
from pmwvc_analysis.replay.targets import is_remote, remote_hand
from pmwvc_analysis.traces.stages import stages
from pmwvc_core.errors import RecordingError
from pmwvc_core.frame.schedule import AT_ONCE, LIVE, FrameSchedule
from pmwvc_core.numeric import Array
from pmwvc_core.plant.forces import ForceOnRecord, Operator
from pmwvc_core.scenario.changes import Change, changes_text
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions, Integers, Steps
from pmwvc_core.traces import SessionTraces, UserTraces

Hand = Literal["operator", "force"]
ENDS_TOGETHER = 100  # ticks within which users count as having ended together
ANSWER = "answer_ticks"


@dataclass(frozen=True)
class Prescription:
    """A scenario to simulate, under which conditions, and notes for the user."""

    scenario: Scenario
    conditions: Conditions
    hands: dict[str, Hand]
    notes: list[str]


def prescription(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario, *, hand: Hand | None = None
) -> Prescription:
    """Return how to replay a session; kinds of hands (see above) not given are chosen by user.

    Raises
    ------
    RecordingError
        If the recording cannot be replayed so, with the reason.
    """
    users = _matching_users(traces, recorded, replayed)
    tick_s = recorded.tick_s
    index = {user.name: tick_numbers(user.time_s, tick_s) for user in users}
    ticks = _length(index)
    if replayed.duration_s != recorded.duration_s:
        ticks = min(ticks, round(replayed.duration_s / tick_s))
    schedule = _schedule(traces, tick_s)
    loops = {
        user.name: LoopTimes(
            old.master.rate_drop,
            first=int(index[user.name][0] - user.tick[0] % old.master.rate_drop),
            answer=schedule.answer_tick(tick_s=tick_s, rate_drop=old.master.rate_drop),
            ran_ns=_ran_ns(user, index[user.name], ticks),
        )
        for user, old in zip(users, recorded.users, strict=True)
    }
    known = sent_and_used(traces, recorded, loops, _steps(traces, recorded, recorded, ticks))
    networks, notes = links(traces, recorded, replayed, known=known)
    hands: dict[str, Hand] = {
        user.name: hand or _usual_hand(user, trace)
        for user, trace in zip(replayed.users, users, strict=True)
    }
    replayed, changed = _with_changes(traces, recorded, replayed)
    notes += changed
    makers: dict[str, Callable[[], Operator]] = {
        user.name: partial(
            remote_hand, user, traces, loops[user.name], tick_s=tick_s, dof=recorded.dof
        )
        for user in replayed.users
        if hands[user.name] == "operator" and is_remote(user) and traces.source != "simulated"
    }
    makers |= {
        user.name: partial(
            ForceOnRecord, _force(user, index[user.name], ticks), tick_s=tick_s, dof=recorded.dof
        )
        for user in users
        if hands[user.name] == "force"
    }
    conditions = Conditions(
        schedule=schedule,
        first={name: loop.first for name, loop in loops.items()},
        ran_ns={name: loop.ran_ns for name, loop in loops.items()},
        steps=_steps(traces, recorded, replayed, ticks),
        links=networks,
        hands=makers,
    )
    notes += _what_is_not_as_recorded(traces, users)
    return Prescription(replace(replayed, duration_s=ticks * tick_s), conditions, hands, notes)


def _with_changes(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario
) -> tuple[Scenario, list[str]]:
    """Return the scenario with the changes of a live session, and what is to be said of them."""
    found = [stage.change for stage in stages(traces, recorded) if stage.change is not None]
    if traces.source != "live" or not found:
        return replayed, []
    before, after = recorded.flat(), replayed.flat()
    fixed = {name for name, value in after.items() if before.get(name) != value}
    kept = [
        Change(change.time_s, values)
        for change in found
        if (values := {n: v for n, v in change.values.items() if n not in fixed})
    ]
    text = changes_text(kept)
    return replace(replayed, changes=text), [f"parameters change as recorded: {text}"]


def _matching_users(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario
) -> list[UserTraces]:
    """Return the recorded users in the order of the scenario."""
    known = {user.name: user for user in traces.users}
    missing = [user.name for user in recorded.users if user.name not in known]
    if missing:
        raise RecordingError(f"the recording holds no trace of {', '.join(missing)}")
    for name, old, new in (
        ("users", len(recorded.users), len(replayed.users)),
        ("dof", recorded.dof, replayed.dof),
        ("master.tick_s", recorded.tick_s, replayed.tick_s),
    ):
        if old != new:
            raise RecordingError(
                f"{name} = {new}: a replay keeps the recorded {old}; "
                "pmwvc simulate FOLDER/scenario.yaml takes any"
            )
    return [known[user.name] for user in recorded.users]


def _length(index: dict[str, Integers]) -> int:
    """Return the ticks up to the first end of a user that stayed to the end."""
    ends = [int(ticks[-1]) + 1 for ticks in index.values()]
    return min(end for end in ends if end > max(ends) - ENDS_TOGETHER)


def _usual_hand(user: User, trace: UserTraces) -> Hand:
    if user.device.plugin == "simulated" and user.operator.kind != "none":
        return "operator"
    return "force" if np.isfinite(trace.f_h).any() else "operator"


def _force(user: UserTraces, index: Integers, ticks: int) -> Array:
    """Return the recorded force of the hand from the user's first tick on ``(ticks, dof)`` [N]."""
    if not np.isfinite(user.f_h).any():
        raise RecordingError(
            f"{user.name}: no force of the hand was recorded; --hand operator takes the hand "
            "of the scenario"
        )
    within = index < ticks
    rows = np.zeros((ticks, user.f_h.shape[-1]))
    rows[index[within]] = np.nan_to_num(user.f_h[within])
    return rows[int(index[0]) :]


def _schedule(traces: SessionTraces, tick_s: float) -> FrameSchedule:
    """Return the phases of the loops: those of live ones, or those that a replay gives."""
    ticks = traces.metadata.get("replay", {}).get(ANSWER)
    if ticks is not None:
        return FrameSchedule(answer_s=int(ticks) * tick_s)
    return LIVE if traces.source == "live" else AT_ONCE


def _ran_ns(user: UserTraces, index: Integers, ticks: int) -> Integers:
    """Return when each tick of the session ran, -1 where it did not ``(ticks,)``."""
    within = index < ticks
    late_ns = np.rint(user.lateness_s[within] * 1e9).astype(np.int64)
    ran_ns = np.full(ticks, -1, dtype=np.int64)
    ran_ns[index[within]] = index[within] * round(user.tick_s * 1e9) + np.maximum(late_ns, 0)
    return ran_ns


def _steps(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario, ticks: int
) -> Steps | None:
    """Return when the server stepped; on its own grid where its period was changed."""
    server, tick_s = traces.server, recorded.tick_s
    tick_ns = round(tick_s * 1e9)
    if server is None:
        return None
    tick = tick_numbers(server.time_s, tick_s)
    if replayed.server.period_s != recorded.server.period_s:
        tick = np.arange(tick[0], ticks, round(replayed.server.period_s / tick_s))
        return Steps(tick, tick * tick_ns)
    late_s = traces.metadata.get("server_lateness_s")
    late_ns = np.zeros_like(tick)
    if late_s is not None and len(late_s) == len(tick):
        late_ns = np.rint(np.asarray(late_s) * 1e9).astype(np.int64)
    within = tick < ticks
    return Steps(tick[within], tick[within] * tick_ns + np.maximum(late_ns[within], 0))


def _what_is_not_as_recorded(traces: SessionTraces, users: list[UserTraces]) -> list[str]:
    """Return as text what a replay cannot have as it was."""
    notes = [str(event["what"]) for event in traces.events if "started" in str(event["what"])]
    notes = [f"{what}: a replay starts every node once" for what in notes]
    for user in users:
        lost = traces.counts.get(f"/{user.name}/trace", {}).get("missing", 0)
        if lost:
            notes.append(f"{user.name}: {lost} blocks of the trace were not recorded")
        if user.tick[0] != 0:
            notes.append(
                f"{user.name}: the recording begins at tick {user.tick[0]}; the "
                "replay starts there from rest"
            )
    if traces.server is None:
        notes.append("no server trace was recorded: the server is stepped at its nominal times")
    elif np.any(np.diff(traces.server.step) != 1):
        notes.append("some server steps were not recorded; the replay leaves them out")
    return notes
