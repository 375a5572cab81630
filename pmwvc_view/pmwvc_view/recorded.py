# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session for the page, which plays it by itself: all rows, packets and texts; and as a
file for the browser, without a server. Questions to the exact model are not answered there.
"""

import base64
import itertools
import json
import posixpath
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.felt import felt_words
from pmwvc_analysis.traces.stages import stages
from pmwvc_core.ends.server_end import LEAST_M
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_view import SNAPSHOT_S, controls, description
from pmwvc_view.feed.rows import Samples, energies, rows_of, samples
from pmwvc_view.feed.verdict import BAD, GOOD, UNKNOWN
from pmwvc_view.protocol.snapshot import NO_PACKETS, Layout
from pmwvc_view.web.access import PAGE

CAN = frozenset({"pause", "seek", "speed"})  # which the page does itself


class RecordedSession:
    """The ``rows`` of a session, ``snapshot_s`` apart [s], and its ``packets`` in the order of
    their sending; ``summary`` has its verdicts, as in ``summary.json``. Something of the
    scenario's users was recorded.
    """

    def __init__(
        self,
        traces: SessionTraces,
        scenario: Scenario,
        summary: Mapping[str, Any],
        *,
        snapshot_s: float,
    ) -> None:
        names = [user.name for user in scenario.users]
        traces = replace(traces, users=[user for user in traces.users if user.name in names])
        self._traces, self._scenario, self._summary = traces, scenario, summary
        self._scene = traces.server.scene if traces.server else {}
        self.layout = Layout(names, scenario.dof, description.moving(self._scene))
        self._period_s = snapshot_s
        self.packets = packets_of(traces, scenario)
        self.rows = self._made_rows()
        self._write_lags(live=traces.live)

    def _made_rows(self) -> Array:
        """Return the rows of the session, the balances as the report judges them."""
        traces, layout, packets, period_s = self._traces, self.layout, self.packets, self._period_s
        times = np.arange(0.0, traces.duration_s + 0.5 * period_s, period_s)
        links = [packets[packets[:, 0] == k, 2:4] for k in range(2 * len(layout.users))]
        accounts = (energies(each, {}) for each in user_energies(traces, self._scenario))
        found = itertools.chain(samples(traces), self._targets(), *accounts)
        rows = rows_of(times, layout, found, traces.users, links)
        rows[:, 0] = np.arange(1, len(times) + 1)
        return rows

    def _targets(self) -> Iterator[Samples]:
        for user, targets in self._traces.targets.items():
            places = targets.ways(self._scenario)
            yield Samples(f"{user}.target", targets.time_s, places, np.inf)
            yield Samples(f"{user}.held", targets.time_s, np.isfinite(places[:, 0]), np.inf)

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
            known = self.rows[:, 1] < until_s
            self.rows[known, self.layout.slices[name]] = np.nan if value is None else value
        for user in self._traces.users:
            if (away := apart(self._traces, user)) is not None:
                at = np.searchsorted(away.time_s, self.rows[:, 1] + 1e-9) - 1
                kept = np.linalg.norm(away.kept[at], axis=-1) > LEAST_M
                self.rows[(at >= 0) & kept, self.layout.slices[f"{user.name}.lag"]] = np.nan

    def declared(self) -> dict[str, Any]:
        """Return the session message; it begins where every user's handle has a place."""
        there = [
            np.isfinite(self.rows[:, self.layout.slices[f"{user.name}.x_m"]]).all(axis=-1)
            for user in self._traces.users
        ]
        about = description.describe(
            self._scenario,
            self.layout,
            self._scene,
            mode="recorded",
            duration_s=self._traces.duration_s,
            values=controls.values_of(self._scenario),
            remote=(),
            can=CAN,
            snapshot_s=self._period_s,
        )
        return about | {"start_s": float(self.rows[np.logical_and.reduce(there).argmax(), 1])}

    def texts(self) -> list[tuple[int, dict[str, Any]]]:
        """Return the texts with the rows from which they hold."""
        same = itertools.groupby(range(len(self.rows)), self._text)
        return [(next(rows), text) for text, rows in same]

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
        time_s = self.rows[index, 1]
        state = float(self.rows[index, self.layout.slices[f"{user}.state"]][0])
        word, reason = "no data", ""
        if np.isfinite(state):
            word = SafetyState(int(state)).name.lower()
            own = next(one for one in self._traces.users if one.name == user)
            at = np.searchsorted(own.block_time_s, time_s, side="right")
            reason = own.reason[max(int(at) - 1, 0)]
        felt = next((felt_words(e) for e in self._summary["users"] if e["name"] == user), "")
        return {"state": word, "reason": reason, "note": "", "felt": felt}


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


ROWS, PACKETS = 4000, 40_000  # at most; of longer sessions fewer a second
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; "
    "style-src 'unsafe-inline'; img-src data:"
)


def replay_page(
    traces: SessionTraces, scenario: Scenario, summary: Mapping[str, Any]
) -> str | None:
    """Return the page of a session with its ``summary``; None if nothing of its users is known."""
    if not {user.name for user in scenario.users} & {user.name for user in traces.users}:
        return None
    period_s = max(SNAPSHOT_S, traces.duration_s / ROWS)
    session = RecordedSession(traces, scenario, summary, snapshot_s=period_s)
    packets = session.packets
    arrived = np.isfinite(packets[:, 3])  # all that were lost are kept
    kept = ~arrived | (np.cumsum(arrived) % (len(packets) // PACKETS + 1) == 0)
    content = {
        "declared": session.declared(),
        "texts": session.texts(),
        "rows": _packed(session.rows),
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
    for file in PAGE.rglob("*.js"):
        name = file.relative_to(PAGE.parent).as_posix()

        def named(found: re.Match[str], folder: str = posixpath.dirname(name)) -> str:
            return f'from "{posixpath.normpath(posixpath.join(folder, found[1]))}"'

        module = re.sub(r"""from ["'](\.[^"']+)["']""", named, file.read_text("utf-8"))
        modules[name] = _address(module.encode(), "text/javascript")
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
