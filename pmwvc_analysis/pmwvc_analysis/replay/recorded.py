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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pmwvc_analysis.recording.parameter_events import owner_of
from pmwvc_analysis.replay import times
from pmwvc_analysis.replay.times import links, tick_numbers
from pmwvc_analysis.traces.stages import Stage
from pmwvc_analysis.traces.stages import stages as stages_of
from pmwvc_core.ends.user_end import CATCH_UP_S
from pmwvc_core.errors import RecordingError
from pmwvc_core.frame import AT_ONCE, LIVE, FrameSchedule
from pmwvc_core.numeric import Flags, Integers
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.plant.hands import Made
from pmwvc_core.plant.remote_hand import TableHand, TableParams, remote_params, resting_remote
from pmwvc_core.scenario.names import Change, changes_text
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions, Steps
from pmwvc_core.traces import SessionTraces, UserTraces

Hand = Literal["operator", "force"]
ENDS_TOGETHER = 100  # ticks within which users count as having ended together: stayed to the end
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
    RecordingError with the reason where the recording cannot be replayed so.
    """
    users = _matching_users(traces, recorded, replayed)
    tick_s = recorded.tick_s
    loops = {user.name: times.times_of(user, user.tick_s) for user in users}
    ends = [int(loop.at[-1]) + 1 for loop in loops.values()]
    ticks = min(end for end in ends if end > max(ends) - ENDS_TOGETHER)
    if replayed.duration_s != recorded.duration_s:
        ticks = min(ticks, round(replayed.duration_s / tick_s))
    # the phases of the loops: those of live ones, or those that a replay gives
    schedule = LIVE if traces.live else AT_ONCE
    if (answer := traces.metadata.get("replay", {}).get(ANSWER)) is not None:
        schedule = FrameSchedule(answer_s=int(answer) * tick_s)
    ran_ns = {name: times.ran_ns(loop, tick_s, ticks) for name, loop in loops.items()}
    receivers = {f"{name}/down": loop for name, loop in loops.items()}
    if traces.server is not None:
        at_server = times.times_of(traces.server, tick_s)
        receivers |= {f"{name}/up": at_server for name in loops}
    networks, notes = links(traces, recorded, replayed, receivers)
    stages = stages_of(traces, recorded)
    steps = times.steps(traces, recorded, replayed, ticks)
    if traces.live:
        replayed, changed = _with_changes(recorded, replayed, stages, ran_ns, steps)
        notes += changed
    hands: dict[str, Hand] = {}
    made: dict[str, Made] = {}
    first: dict[str, int] = {}
    for number, (user, trace) in enumerate(zip(replayed.users, users, strict=True)):
        name, ran = user.name, ran_ns[user.name]
        first[name] = times.counts_from(trace, traces, stages, number)
        plays = user.device.is_simulated and user.operator.kind != "none"
        known = not plays and np.isfinite(trace.f_h).any()
        hands[name] = hand or ("force" if known else "operator")
        if hands[name] == "force":
            made[name] = recorded_force(trace, ran, tick_s=tick_s, dof=recorded.dof)
        elif user.operator.is_remote and traces.source != "simulated":
            made[name] = remote_hand(user, traces, ran, recorded)
    conditions = Conditions(
        schedule=schedule, first=first, ran_ns=ran_ns, steps=steps, links=networks, hands=made
    )
    if traces.server is None:
        notes.append("no server trace was recorded: the server is stepped at its nominal times")
    return Prescription(replace(replayed, duration_s=ticks * tick_s), conditions, hands, notes)


def _matching_users(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario
) -> list[UserTraces]:
    """Return the recorded users in the order of the scenario."""
    known = {user.name: user for user in traces.users}
    if missing := [user.name for user in recorded.users if user.name not in known]:
        raise RecordingError(f"the recording holds no trace of {', '.join(missing)}")
    for name, old, new in (
        ("users", len(recorded.users), len(replayed.users)),
        ("dof", recorded.dof, replayed.dof),
        ("master.tick_s", recorded.tick_s, replayed.tick_s),
    ):
        if old != new:
            other = "pmwvc simulate FOLDER/scenario.yaml takes any"
            raise RecordingError(f"{name} = {new}: a replay keeps the recorded {old}; {other}")
    return [known[user.name] for user in recorded.users]


def _with_changes(
    recorded: Scenario,
    replayed: Scenario,
    stages: Sequence[Stage],
    ran_ns: Mapping[str, Integers],
    steps: Steps | None,
) -> tuple[Scenario, list[str]]:
    """Return the scenario with the recorded changes but for what was set for the replay, and a
    note of them.
    """
    found = [stage.change for stage in stages if stage.change is not None]
    if not found:
        return replayed, []
    before, after = recorded.flat(), replayed.flat()
    fixed = {name for name, value in after.items() if before.get(name) != value}
    loops = {name: (np.flatnonzero(each >= 0), each[each >= 0]) for name, each in ran_ns.items()}
    if steps is not None:
        loops[""] = steps.tick, steps.ran_ns
    kept = [
        Change(_ran_s(change, loops, recorded.tick_s), values)
        for change in found
        if (values := {n: v for n, v in change.values.items() if n not in fixed})
    ]
    text = changes_text(kept)
    return replace(replayed, changes=text), [f"parameters change as recorded: {text}"]


def _ran_s(change: Change, loops: Mapping[str, tuple[Integers, Integers]], tick_s: float) -> float:
    """Return when the tick or step ran that took a change over [s]."""
    owner = owner_of(change.values)
    if owner is None or owner not in loops:
        return change.time_s
    tick, ran_ns = loops[owner]
    row = int(np.searchsorted(tick, change.time_s / tick_s))
    return float(ran_ns[row] * 1e-9) if row < len(tick) else change.time_s


def recorded_force(user: UserTraces, ran_ns: Integers, *, tick_s: float, dof: int) -> Made:
    """Return the recorded force, tick for tick; RecordingError where there is none.

    The force in ticks that did not run is interpolated; ``ran_ns`` is negative for these.
    """
    if not np.isfinite(user.f_h).any():
        other = "--hand operator takes the hand of the scenario"
        raise RecordingError(f"{user.name}: no force of the hand was recorded; {other}")
    at, force = tick_numbers(user.time_s, tick_s), np.nan_to_num(user.f_h)
    every = np.flatnonzero(_passing(ran_ns, tick_s))
    rows = np.stack([np.interp(every, at, axis) for axis in force.T], axis=-1)
    return RecordedForce(0), recorded_params(rows, dof, repeat=False, early=True)


def remote_hand(user: User, traces: SessionTraces, ran_ns: Integers, recorded: Scenario) -> Made:
    """Return the remote hand with recorded targets, each at the first tick after the one that ran
    before it: missed ticks are made up for with it. RecordingError for a replay: it has none.
    """
    if not traces.live:
        why = f"a {traces.source} session holds no targets of a remote hand"
        raise RecordingError(f"{user.name}: {why}; replay the recording that it was made from")
    found, tick_s, dof = traces.targets.get(user.name), recorded.tick_s, recorded.dof
    ticks, rows = np.zeros(0, dtype=np.int64), np.zeros((0, dof))
    if found is not None:
        ran = np.flatnonzero(ran_ns >= 0)
        next_ran = np.searchsorted(ran_ns[ran], np.rint(found.time_s * 1e9))
        passed = np.cumsum(_passing(ran_ns, tick_s))[ran]
        ticks, rows = np.append(0, passed)[next_ran], found.ways(recorded)
    p = TableParams(remote_params(user.operator, tick_s), ticks, rows, tuple(range(dof)), True)
    return TableHand(resting_remote((0.0,) * dof), 0, 0), p


def _passing(ran_ns: Integers, tick_s: float) -> Flags:
    """Tell in which ticks of the session a hand moves: those that ran, and after each as many that
    did not as a simulated device makes up for (``CATCH_UP_S``).
    """
    ran, every = ran_ns >= 0, np.arange(len(ran_ns))
    latest = np.maximum.accumulate(np.where(ran, every, -1))
    return np.asarray((latest >= 0) & (every - latest < max(1, round(CATCH_UP_S / tick_s))))
