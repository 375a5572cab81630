# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session of a page that was recorded: played, stopped, and moved along a time line; and as a
file for the browser: the live page with the session in it, without a server. Questions to the
exact model are not answered there.
"""

import base64
import json
import re
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.traces.apart import apart, kept_text
from pmwvc_analysis.traces.stages import stages
from pmwvc_core.ends.server_end import LEAST_M
from pmwvc_core.errors import RecordingError
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_view import SNAPSHOT_S, controls, description
from pmwvc_view.description import Predictor
from pmwvc_view.feed.verdict import BAD, GOOD, UNKNOWN
from pmwvc_view.protocol.snapshot import Layout, Snapshot
from pmwvc_view.recorded.rows import packets_of, rows_of
from pmwvc_view.session import Handled, Session
from pmwvc_view.web.access import PAGE

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
        self._names = [user.name for user in scenario.users]
        if not {user.name for user in traces.users} & set(self._names):
            raise RecordingError("nothing was recorded of the users of its scenario")
        super().__init__(Predictor(live=traces.live))
        self._traces, self._scenario, self._summary = traces, scenario, summary
        self.layout = Layout(self._names, scenario.dof)
        self._rows = rows_of(traces, scenario, self.layout, period_s=snapshot_s)
        self._packets = packets_of(traces, scenario)
        self._apart = {user.name: apart(traces, user) for user in traces.users}
        self._write_lags(live=traces.live)
        self._clock, self._period_s = clock, snapshot_s
        there = [  # every user's handle has a place
            np.isfinite(self._rows[:, self.layout.slices[f"{user.name}.x_m"]]).all(axis=-1)
            for user in traces.users
            if user.name in self._names
        ]
        self._start_s = float(self._rows[int(np.logical_and.reduce(there).argmax()), 1])
        self._time_s, self._at_s = self._start_s, clock()
        self._ratio, self._paused = 1.0, True
        self._shown, self._seq = -1, 0  # row shown last; number of it

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
            if away is not None and f"{user}.lag" in self.layout.slices:
                at = np.searchsorted(away.time_s, self._rows[:, 1] + 1e-9) - 1
                kept = np.linalg.norm(away.kept[at], axis=-1) > LEAST_M
                self._rows[(at >= 0) & kept, self.layout.slices[f"{user}.lag"]] = np.nan

    def description(self) -> dict[str, Any]:
        """Return the session message without what the server adds."""
        found = description.describe(
            self._scenario, mode="recorded", duration_s=self._traces.duration_s,
            values=controls.values_of(self._scenario), remote=[],
        )  # fmt: skip
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
            "users": {user: self._state(user, index) for user in self._names},
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
        return {"state": word, "reason": reason, "note": note}

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


ROWS, PACKETS = 4000, 40_000  # at most; of longer sessions fewer a second
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; "
    "style-src 'unsafe-inline'; img-src data:"
)


def replay_page(
    traces: SessionTraces, scenario: Scenario, summary: Mapping[str, Any]
) -> str | None:
    """Return the page of a recorded session; None if nothing of its users was recorded.
    ``summary`` has its verdicts, as in ``summary.json``.
    """
    period_s = max(SNAPSHOT_S, traces.duration_s / ROWS)
    try:
        session = RecordedSession(traces, scenario, summary, snapshot_s=period_s)
    except RecordingError:
        return None
    session.can = frozenset({"pause", "seek", "speed"})  # what the page does itself
    rows, packets, texts = session.whole()
    arrived = np.isfinite(packets[:, 3])  # all that were lost are kept
    kept = ~arrived | (np.cumsum(arrived) % (len(packets) // PACKETS + 1) == 0)
    content = {
        "declared": session.message(holders={}, snapshot_s=period_s),
        "texts": texts,
        "rows": _packed(rows),
        "packets": _packed(packets[kept]),
    }
    return _page(json.dumps(content, allow_nan=False).replace("<", "\\u003c"))


def _packed(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode("ascii")


def _page(content: str) -> str:
    """Return the page with style, scripts and session in it."""
    text = (PAGE / "index.html").read_text("utf-8")
    icon = _address((PAGE / "icon.svg").read_bytes(), "image/svg+xml")
    modules = {}
    for file in PAGE.glob("*.js"):
        module = re.sub(r'from "\./', 'from "page/', file.read_text("utf-8"))
        modules[f"page/{file.name}"] = _address(module.encode(), "text/javascript")
    style = (PAGE / "page.css").read_text("utf-8")
    text = re.sub(r'  <link rel="(modulepreload|stylesheet)".*\n', "", text)
    text = text.replace('href="icon.svg"', f'href="{icon}"')
    head = f"""  <meta http-equiv="Content-Security-Policy" content="{POLICY}">
  <style>{style}</style>
  <script type="importmap">{json.dumps({"imports": modules})}</script>
  <script type="application/json" id="recording">{content}</script>
  <script type="module">import "page/main.js";</script>
"""
    return text.replace('  <script type="module" src="main.js"></script>\n', head)


def _address(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
