# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The replay of a session, in arrays: how far it is from its recording, and what keeps it from
being the same to the last bit. Nothing is written here.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.recording.reader import read_scenario
from pmwvc_analysis.replay.recorded import ANSWER, Hand, Prescription, prescription
from pmwvc_analysis.replay.scene_files import as_described
from pmwvc_analysis.replay.times import own_sender, tick_numbers
from pmwvc_analysis.traces import sums
from pmwvc_analysis.traces.holes import SERVER, holes, of_user, starts
from pmwvc_core.errors import RecordingError
from pmwvc_core.frame import SIGNALS
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces, UserTraces

FORCE_N = 0.1
POSITION_M = 0.5e-3
NEAR_S = 0.001  # a change is noted just before the tick or step that took it over


def differences(recorded: SessionTraces, replayed: SessionTraces) -> list[dict[str, Any]]:
    """Return per user the largest and RMS difference, tick by tick, of force and position, and the
    first tick at which either is not the same to the last bit, with the signals that differ then.

    ``missing`` are ticks that only one of both has up to the end of the replay: they cannot be
    compared.
    """
    others = {user.name: user for user in replayed.users}
    return [_difference(user, others[user.name]) for user in recorded.users]


def _difference(user: UserTraces, other: UserTraces) -> dict[str, Any]:
    own, again = (tick_numbers(each.time_s, user.tick_s) for each in (user, other))
    _, mine, theirs = np.intersect1d(own, again, return_indices=True)
    force = user.f_applied[mine] - other.f_applied[theirs]
    position = user.x_m[mine] - other.x_m[theirs]
    apart = np.flatnonzero(np.any((force != 0.0) | (position != 0.0), axis=-1))
    first: dict[str, Any] = {"first_tick": None, "first_s": None, "first_signals": []}
    if len(apart):
        row, twin = int(mine[apart[0]]), int(theirs[apart[0]])
        pairs = ((name, getattr(user, name)[row], getattr(other, name)[twin]) for name in SIGNALS)
        differ = [name for name, a, b in pairs if not np.array_equal(a, b, equal_nan=True)]
        first_s = float(own[row] * user.tick_s)
        first = {"first_tick": int(user.tick[row]), "first_s": first_s, "first_signals": differ}
    return {
        "name": user.name,
        "ticks": len(mine),
        "missing": len(again) + int((own <= again.max(initial=-1)).sum()) - 2 * len(mine),
        **first,
        "force_max_n": _largest(force),
        "force_rms_n": sums.rms(force),
        "position_max_m": _largest(position),
        "position_rms_m": sums.rms(position),
    }


def exact(found: list[dict[str, Any]]) -> bool:
    """Tell whether every tick was compared, and was the same to the last bit."""
    return bool(found) and all(
        user["force_max_n"] == user["position_max_m"] == 0.0 and not user["missing"]
        for user in found
    )


def reproduced(found: list[dict[str, Any]]) -> bool:
    """Tell whether force and position were met within ``FORCE_N`` and ``POSITION_M``."""
    most = {"force_max_n": FORCE_N, "position_max_m": POSITION_M}
    apart = ((user[name], largest) for user in found for name, largest in most.items())
    return all(value is not None and value <= largest for value, largest in apart)


def _largest(values: Array) -> float | None:
    lengths = np.linalg.norm(values, axis=-1)
    return sums.number(lengths.max()) if len(lengths) else None


class Inexact(NamedTuple):
    """Why a replay is not exact from a time on [s]."""

    time_s: float
    why: str


@dataclass(frozen=True)
class Replay:
    """A recorded session, its replay, and how far they are apart."""

    recorded: SessionTraces
    recorded_scenario: Scenario
    replayed: SessionTraces
    prescribed: Prescription
    changes: dict[str, Any]  # parameters that were changed, by dotted name: the new value
    differences: list[dict[str, Any]]
    limits: list[Inexact]  # why it cannot be exact

    @property
    def scenario(self) -> Scenario:
        """The scenario of the replay."""
        return self.prescribed.scenario

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the MCAP metadata record of a replay."""
        hands = {f"hand.{name}": hand for name, hand in self.prescribed.hands.items()}
        changed = {f"set.{name}": str(value) for name, value in self.changes.items()}
        answer_s = self.prescribed.conditions.schedule.answer_s
        answer = {ANSWER: str(round(answer_s / self.scenario.tick_s))}
        return {"replay": {**answer, **hands, **changed}}


def scenario_of(folder: Path) -> Scenario:
    """Return the scenario of a session folder; RecordingError where it has none."""
    if not folder.is_dir():
        raise RecordingError(f"{folder}: there is no such session folder")
    if (scenario := read_scenario(folder)) is None:
        need = "a replay needs the parameters of the session"
        raise RecordingError(f"{folder} holds no scenario.yaml: {need}")
    return scenario


def replay(
    traces: SessionTraces,
    recorded: Scenario,
    replayed: Scenario,
    *,
    hand: Hand | None = None,
    progress: Callable[[float], None] | None = None,
) -> Replay:
    """Replay a recorded session with another scenario; ``progress`` gets the ratio done, 0..1.
    RecordingError where that cannot be. The kinds of hands: :mod:`pmwvc_analysis.replay.recorded`.
    A scene is that of the recording, whatever became of its files.
    """
    prescribed = prescription(traces, recorded, replayed, hand=hand)
    kept: dict[str, Any] = {"keep": lambda result, _: result, "progress": progress}
    same = replayed.server.scene == recorded.server.scene
    with as_described(prescribed.scenario, traces.server if same else None) as scenario:
        (result,) = simulate([scenario], conditions=prescribed.conditions, **kept)
    result.source = "replayed"
    before = recorded.flat()
    changes = {n: value for n, value in replayed.flat().items() if before.get(n) != value}
    apart, why = differences(traces, result), limits(traces, recorded, prescribed.hands)
    found = Replay(traces, recorded, result, prescribed, changes, apart, why)
    result.metadata.update(found.metadata())
    return found


def limits(traces: SessionTraces, recorded: Scenario, hands: Mapping[str, str]) -> list[Inexact]:
    """Return, by time, why an unchanged replay with these kinds of hands cannot be exact."""
    found = [*_unrecorded(traces), *_restarts(traces), *_unnamed_changes(traces)]
    if traces.live and traces.server is not None and (late := traces.server.replaced)[1]:
        found.append(Inexact(late[0], f"a damper in place of the environment: {late[1]}x"))
    for user in recorded.users:
        if traces.live and not user.device.is_simulated:
            why = "the device was a real one; here its model moves"
            found.append(Inexact(0.0, f"{user.name}: {why}"))
        led = user.operator.is_remote and user.name in traces.targets
        if led and hands[user.name] == "operator":  # the recorder may get a target later
            why = "the tick at which a target reached the hand was not recorded"
            found.append(Inexact(0.0, f"{user.name}: {why}"))
    found += [limit for u in traces.users if hands[u.name] == "force" for limit in _pauses(u)]
    return sorted(found)


def _pauses(user: UserTraces) -> Iterator[Inexact]:
    """Yield pauses of a loop in which a recorded hand pushed a device that moved on."""
    gaps = [(hole.start_s, hole.end_s) for hole in of_user(user)]
    missed = tick_numbers(np.diff(user.time_s), user.tick_s) - 1
    pushed = (np.nan_to_num(user.f_h) != 0.0).any(axis=-1)
    for row in np.flatnonzero((missed > 0) & (pushed[:-1] | pushed[1:])).tolist():
        start_s, end_s = user.time_s[row : row + 2].tolist()
        if not any(first < end_s and start_s < last for first, last in gaps):
            why = f"{user.name}: the force of the hand in {missed[row]} ticks that did not run"
            yield Inexact(start_s + user.tick_s, f"{why} is interpolated")


def _unrecorded(traces: SessionTraces) -> Iterator[Inexact]:
    """Yield what the recording lacks."""
    for hole in holes(traces):
        what = "steps of the server" if hole.owner == SERVER else "blocks of its trace"
        who = "" if hole.owner == SERVER else f"{hole.owner}: "
        yield Inexact(hole.start_s, f"{who}{hole.missing} {what} were not recorded")
    for user in traces.users:
        for way in ("up", "down"):
            name = f"{user.name}/{way}"
            if (taken := traces.taken.get(name)) is None:
                yield Inexact(0.0, f"{name}: when packets were taken in was not recorded")
            elif (strange := taken.epoch != own_sender(traces, name)).any():
                rows = traces.server if way == "up" else user
                time_s = float(rows.time_s[taken.row[strange][0]]) if rows is not None else 0.0
                why = f"{name}: {strange.sum()} packets of another start of the sender came"
                yield Inexact(time_s, why)


def _restarts(traces: SessionTraces) -> Iterator[Inexact]:
    """Yield nodes that were started again."""
    why = "was started again: a replay starts every node once"
    for user in traces.users:
        for row in np.flatnonzero(user.epoch[1:] != user.epoch[:-1]).tolist():
            yield Inexact(float(user.block_time_s[row]), f"{user.name}: the master {why}")
    if (server := traces.server) is not None:
        for row in starts(server):
            yield Inexact(float(server.time_s[row]), f"the server {why}")


def _unnamed_changes(traces: SessionTraces) -> Iterator[Inexact]:
    """Yield what a loop took over in flight and no change of a parameter names."""
    if not traces.live:
        return
    named = np.array([time_s for time_s, _ in traces.settings])
    loops = [(f"{u.name}: the master", u.changes, u.time_s[u.block_rows]) for u in traces.users]
    if traces.server is not None:
        loops.append(("the server", traces.server.changes, traces.server.time_s))
    for who, changes, time_s in loops:
        for row in np.flatnonzero(np.diff(changes) > 0).tolist():
            at_s = float(time_s[row + 1])
            if not np.any(np.abs(named - at_s) < NEAR_S):
                why = "took over a change that no recorded parameter event names"
                yield Inexact(at_s, f"{who} {why}")
