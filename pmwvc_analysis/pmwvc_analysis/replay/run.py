# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The replay of a session, in arrays: how far it is from its recording. Nothing is written
here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmwvc_analysis.replay.recorded import ANSWER, Hand, Prescription, prescription
from pmwvc_analysis.replay.scene_files import as_described
from pmwvc_analysis.replay.times import tick_numbers
from pmwvc_analysis.traces import sums
from pmwvc_core.frame import SIGNALS
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces, UserTraces

FORCE_N = 0.1
POSITION_M = 0.5e-3


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


@dataclass(frozen=True)
class Replay:
    """A recorded session, its replay, and how far they are apart."""

    recorded: SessionTraces
    recorded_scenario: Scenario
    replayed: SessionTraces
    prescribed: Prescription
    changes: dict[str, Any]  # parameters that were changed, by dotted name: the new value
    differences: list[dict[str, Any]]

    @property
    def scenario(self) -> Scenario:
        """The scenario of the replay."""
        return self.prescribed.scenario


def replay(
    traces: SessionTraces,
    recorded: Scenario,
    replayed: Scenario,
    *,
    hand: Hand | None = None,
    progress: Callable[[float], None] = lambda ratio: None,
) -> Replay:
    """Replay a recorded session with another scenario; ``progress`` gets the ratio done, 0..1.
    RecordingError where that cannot be. The kinds of hands: :mod:`pmwvc_analysis.replay.recorded`.
    A scene is that of the recording, whatever became of its files.
    """
    prescribed = prescription(traces, recorded, replayed, hand=hand)
    same = replayed.server.scene == recorded.server.scene
    with as_described(prescribed.scenario, traces.server if same else None) as scenario:
        result = simulate_one(scenario, prescribed.conditions, progress=progress)
    result.source = "replayed"
    before = recorded.flat()
    changes = {n: value for n, value in replayed.flat().items() if before.get(n) != value}
    apart = differences(traces, result)
    answer_s, tick_s = prescribed.conditions.schedule.answer_s, prescribed.scenario.tick_s
    result.metadata["replay"] = {
        ANSWER: str(round(answer_s / tick_s)),
        **{f"hand.{name}": of for name, of in prescribed.hands.items()},
        **{f"set.{name}": str(value) for name, value in changes.items()},
    }
    return Replay(traces, recorded, result, prescribed, changes, apart)
