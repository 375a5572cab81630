# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that was recorded: played, stopped, and moved along a time line."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.apart import apart, kept_text
from pmwvc_analysis.traces.felt import felt_words
from pmwvc_analysis.traces.stages import stages
from pmwvc_core.ends.server_end import LEAST_M
from pmwvc_core.errors import RecordingError
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_view import description
from pmwvc_view.description import Predictor
from pmwvc_view.feed.rows import Source, UserTicks, rows_of
from pmwvc_view.feed.tape import AVATAR, OBJECT, SIGNALS
from pmwvc_view.feed.verdict import BAD, GOOD, UNKNOWN
from pmwvc_view.protocol.snapshot import NO_PACKETS, Layout, Snapshot
from pmwvc_view.session import Handled, Session

SLOWEST, FASTEST = 0.01, 4.0


class RecordedSession(Session):
    """See :class:`.session.Session`; ``summary`` has its verdicts, as in ``summary.json``.
    RecordingError where nothing of the scenario's users was recorded.
    """

    can = frozenset({"ask", "pause", "seek", "speed", "seen"})

    def __init__(
        self, traces: SessionTraces, scenario: Scenario, summary: Mapping[str, Any], *,
        snapshot_s: float, clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        names = [user.name for user in scenario.users]
        traces = replace(traces, users=[user for user in traces.users if user.name in names])
        if not traces.users:
            raise RecordingError("nothing was recorded of the users of its scenario")
        super().__init__(Predictor(live=traces.live), mode="recorded")
        self._traces, self._scenario, self._summary = traces, scenario, summary
        self.layout, self._duration_s = Layout(names, scenario.dof), traces.duration_s
        self._packets = packets_of(traces, scenario)
        self._rows = self._made_rows(snapshot_s)
        self._apart = {user.name: apart(traces, user) for user in traces.users}
        self._write_lags(live=traces.live)
        self._clock, self._period_s = clock, snapshot_s
        there = [  # every user's handle has a place
            np.isfinite(self._rows[:, self.layout.slices[f"{user.name}.x_m"]]).all(axis=-1)
            for user in traces.users
        ]
        self._start_s = float(self._rows[int(np.logical_and.reduce(there).argmax()), 1])
        self._time_s, self._at_s = self._start_s, clock()
        self._ratio, self._paused = 1.0, True
        self._shown, self._seq = -1, 0  # row shown last; number of it

    def _made_rows(self, period_s: float) -> Array:
        """Return the rows of the session, the balances as the report judges them."""
        traces, layout, packets = self._traces, self.layout, self._packets
        times = np.arange(0.0, traces.duration_s + 0.5 * period_s, period_s)
        links = [packets[packets[:, 0] == k, 2:4] for k in range(2 * len(layout.users))]
        ticks = [
            UserTicks(user.name, user.time_s, user.f_applied, user.lateness_s)
            for user in traces.users
        ]
        sources = (
            Source(time_s, [(layout.slices[column], values)], *within_s)
            for column, time_s, values, *within_s in self._samples()
            if column in layout.slices  # a server may have had other users
        )
        rows = rows_of(times, layout, sources, ticks, links)
        rows[:, 0] = np.arange(1, len(times) + 1)
        return rows

    def _samples(self) -> Iterator[tuple[Any, ...]]:
        """Yield columns with their samples as a :class:`Source` has them."""
        if (server := self._traces.server) is not None:
            for name in OBJECT:
                yield f"object.{name}", server.time_s, getattr(server, name)
            for index, user in enumerate(server.users):
                for name in (*AVATAR, "contact"):
                    yield f"{user}.{name}", server.time_s, getattr(server, name)[index]
                yield f"{user}.presence", server.time_s, server.state[index]
        for one in self._traces.users:
            for name in SIGNALS:
                yield f"{one.name}.{name}", one.time_s, getattr(one, name)
            yield f"{one.name}.state", one.block_time_s, one.state
        for energy in user_energies(self._traces, self._scenario):
            for way, balance in (("up", energy.up), ("down", energy.down), ("hand", energy.joint)):
                if balance is not None:
                    least = np.minimum(np.minimum.accumulate(balance.balance_j), 0.0)
                    amounts = balance.energy_in_j, balance.energy_out_j, least
                    for name, values in zip(("in", "out", "min"), amounts, strict=True):
                        yield f"{energy.name}.energy_{way}_{name}", balance.time_s, values, np.inf
        for user, targets in self._traces.targets.items():
            places = targets.position[:, : self.layout.dof]
            yield f"{user}.target", targets.time_s, places, np.inf
            yield f"{user}.held", targets.time_s, np.isfinite(places[:, 0]), np.inf

    def _write_lags(self, *, live: bool) -> None:
        """Write lags and impedances as far as they stayed what they were: under load the distance
        of device and avatar keeps a part of the former ones. No lag where the distance is kept
        since joining.
        """
        parts = stages(self._traces, self._scenario)
        every = [description.lags(part.scenario, live=live) for part in parts]
        for name, value in every[0].items():
            same = [each[name] == value for each in every]
            until_s = np.inf if all(same) else parts[same.index(False)].start_s
            known = self._rows[:, 1] < until_s
            self._rows[known, self.layout.slices[name]] = np.nan if value is None else value
        for user, away in self._apart.items():
            if away is not None:
                at = np.searchsorted(away.time_s, self._rows[:, 1] + 1e-9) - 1
                kept = np.linalg.norm(away.kept[at], axis=-1) > LEAST_M
                self._rows[(at >= 0) & kept, self.layout.slices[f"{user}.lag"]] = np.nan

    def description(self) -> dict[str, Any]:
        """Return the session message without what the server adds."""
        found = super().description()
        return {**found, "events": self._summary["events"], "start_s": self._start_s}

    def poll(self) -> Sequence[Snapshot]:
        """Return the rows from the last call up to now; where time was moved, the one there."""
        now_s = self._clock()
        passed_s, self._at_s = now_s - self._at_s, now_s
        end_s = self._traces.duration_s
        if not self._paused:
            self._time_s = min(self._time_s + passed_s * self._ratio, end_s)
            self._paused = self._time_s >= end_s
        last = min(int(self._time_s / self._period_s + 1e-9), len(self._rows) - 1)
        first = self._shown + 1 if self._shown <= last else last
        self._shown = last
        return [self._snapshot(index) for index in range(first, last + 1)]

    def _snapshot(self, index: int) -> Snapshot:
        self._seq += 1
        row = self._rows[index].copy()
        row[0] = self._seq
        since_s = self._rows[index - 1, 1] if index else -self._period_s
        begin, end = np.searchsorted(self._packets[:, 2], [since_s, row[1]], side="right")
        return Snapshot(row, self._packets[begin:end])

    def whole(self) -> tuple[Array, Array, list[tuple[int, dict[str, Any]]]]:
        """Return all rows and packets, and the texts with the rows from which they hold."""
        texts: list[tuple[int, dict[str, Any]]] = []
        for index in range(len(self._rows)):
            text = self._text(index)
            if not texts or text != texts[-1][1]:
                texts.append((index, text))
        return self._rows, self._packets, texts

    def news(self) -> Mapping[str, Mapping[str, Any]]:
        """Return the recorded verdict with the states of now, and where time is."""
        time_s = self._time_s if self._paused else None  # the rows tell
        play = {"paused": self._paused, "time_s": time_s, "ratio": self._ratio}
        return {"text": self._text(max(self._shown, 0)), "play": play}

    def _text(self, index: int) -> dict[str, Any]:
        """Return the recorded verdict with the states at a row."""
        lines = self._summary["verdict"]
        levels = {False: BAD, None: UNKNOWN, True: GOOD}
        worst = min(lines, key=lambda line: list(levels).index(line["ok"]))
        level, sentence = levels[worst["ok"]], worst["text"]
        return {
            "verdict": f"The whole session: {sentence}",
            "level": level,
            "users": {user: self._state(user, index) for user in self.layout.users},
            "notices": [line["text"] for line in lines if line["text"] != sentence],
        }

    def _state(self, user: str, index: int) -> dict[str, str]:
        time_s = self._rows[index, 1]
        state = float(self._rows[index, self.layout.slices[f"{user}.state"]][0])
        word, reason = "no data", ""
        if np.isfinite(state):
            word = SafetyState(int(state)).name.lower()
            own = next(one for one in self._traces.users if one.name == user)
            at = np.searchsorted(own.block_time_s, time_s, side="right")
            reason = own.reason[max(int(at) - 1, 0)]
        note, away = "", self._apart.get(user)
        if away is not None:  # from the device since the user joined
            at = int(np.searchsorted(away.time_s, time_s + 1e-9)) - 1
            if at >= 0 and time_s - away.time_s[at] < 2.0 * self._scenario.server.period_s:
                note = kept_text(away.kept[at], self._scenario)
        felt = next((felt_words(e) for e in self._summary["users"] if e["name"] == user), "")
        return {"state": word, "reason": reason, "note": note, "felt": felt}

    async def pause(self, paused: bool) -> Handled:
        """Stop, or play on; from the beginning where the end was reached."""
        if not paused and self._time_s >= self._traces.duration_s:
            self._time_s = 0.0
        self._paused = paused
        return Handled(True, "paused" if paused else "playing")

    def seek(self, time_s: float) -> Handled:
        """Go to another time [s]."""
        self._time_s = min(max(time_s, 0.0), self._traces.duration_s)
        self._shown = int(self._time_s / self._period_s + 1e-9) - 1
        return Handled(True, f"at {self._time_s:.3f} s")

    def speed(self, ratio: float) -> Handled:
        """Play at this ratio of the speed."""
        if not SLOWEST <= ratio <= FASTEST:
            return Handled(False, f"speed = {ratio:g}: must be {SLOWEST:g}..{FASTEST:g}")
        self._ratio = ratio
        return Handled(True, f"{ratio:g} times the speed")


def packets_of(traces: SessionTraces, scenario: Scenario) -> Array:
    """Return all packets of a session in the order of their sending, ``(packets, 5)``."""
    zeros = traces.metadata.get("fate_zero_ns", {})
    found = [NO_PACKETS]
    for index, user in enumerate(scenario.users):
        for way, name in enumerate(("up", "down")):
            if (fates := traces.fates.get(f"{user.name}/{name}")) is None:
                continue
            zero_ns, link = zeros.get(fates.link, 0), np.full(len(fates.number), 2 * index + way)
            in_s, out_s = ((t - zero_ns) * 1e-9 for t in (fates.time_in_ns, fates.time_out_ns))
            arrived_s = np.where(fates.time_out_ns > 0, out_s, np.nan)
            found.append(np.column_stack([link, fates.number, in_s, arrived_s, fates.fate]))
    every = np.concatenate(found)
    return np.asarray(every[np.argsort(every[:, 2], kind="stable")])
