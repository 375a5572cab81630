# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The newest seconds of a running session as traces, which the report's judge takes like any.

What the page does not read is taken as nothing: forces count as asked for as they were applied,
and no wave of the server is too long. The judge begins anew where a parameter changes.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pmwvc_analysis.verdicts import stability
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces, UserTraces
from pmwvc_view.feed.traces import AVATAR, NS, OBJECT, SIGNALS, TraceBlock, TraceStep

SPAN_S = 6.0  # of which the newer half is judged
JUDGED_S = 0.5  # between two judgements
LATE_S = 1.0  # newest part, in which a force is at its limit or not
AT_LIMIT = 0.999
OUT, SEQ = 2, 0  # columns of packets


class Window:
    """See above. ``why`` tells what makes the session unstable as of now, empty: nothing does;
    ``was`` what did last, and until when [s]; ``limited`` whose force is at its largest [N].
    ``zero_ns`` is where time counts from; the feed sets it.
    """

    def __init__(self, users: Sequence[str]) -> None:
        self._users = users
        self._blocks = {user: deque[TraceBlock]() for user in users}
        self._steps = deque[TraceStep]()
        self._packets = [deque[Array]() for _ in range(2 * len(users))]
        self.zero_ns = self._judged_ns = self._end_ns = 0
        self.why, self.was = "", ("", 0.0)
        self.limited: dict[str, float] = {}

    def block(self, user: str, block: TraceBlock) -> None:
        """Take in consecutive ticks of a master."""
        self._blocks[user].append(block)
        self._end_ns = max(self._end_ns, block.end_ns)
        for blocks in self._blocks.values():
            while blocks and blocks[0].start_ns < self._end_ns - SPAN_S * NS:
                blocks.popleft()

    def step(self, step: TraceStep) -> None:
        """Take in a step of the server."""
        self._steps.append(step)
        while self._steps[0].start_ns < step.start_ns - SPAN_S * NS:
            self._steps.popleft()

    def packets(self, link: int, columns: Array) -> None:
        """Take in packets of a link that came out, ``(n, 4)`` as the feed has them."""
        kept, out = self._packets[link], columns[columns[:, OUT] > 0]
        if len(out):
            kept.append(out)
        while kept and kept[0][-1, OUT] < self._end_ns - SPAN_S * NS:
            kept.popleft()

    def changed(self) -> None:
        """Begin anew: what was before a change of parameters says nothing of what is."""
        self._steps.clear()
        for blocks in self._blocks.values():
            blocks.clear()
        for packets in self._packets:
            packets.clear()

    def judge(self, scenario: Scenario | None, *, live: bool) -> None:
        """Judge what is new, twice a second at most; the scenario is that of now."""
        if self._end_ns < self._judged_ns + JUDGED_S * NS:
            return
        self._judged_ns = self._end_ns
        now = replace(scenario, changes="") if scenario else None
        since_s = float(self._seconds(self._end_ns)) - 0.5 * SPAN_S
        found = stability.verdict(self.traces(now, live=live), now, since_s=since_s)
        unstable = f"{found.instability}: {found.why}" if found.stable is False else ""
        if self.why and not unstable:
            self.was = self.why, float(self._seconds(self._end_ns))
        self.why = unstable
        most = {user.name: user.safety.max_force for user in scenario.users} if scenario else {}
        self.limited = {name: force for name, force in most.items() if self._stays(name, force)}

    def _stays(self, user: str, force_n: float) -> bool:
        """Tell whether a user's force was this large for most of the newest second."""
        since_ns = self._end_ns - LATE_S * NS
        new = [each.f_applied for each in self._blocks[user] if each.start_ns > since_ns]
        sizes = [np.linalg.norm(each, axis=-1) >= AT_LIMIT * force_n for each in new]
        return bool(new) and bool(np.mean(np.concatenate(sizes)) > 0.5)

    def traces(self, scenario: Scenario | None, *, live: bool) -> SessionTraces:
        """Return what is kept, its time counted from the first trace of the session."""
        users = [self._user(name, list(kept)) for name, kept in self._blocks.items() if kept]
        duration_s = max((float(each.time_s[-1]) + each.tick_s for each in users), default=0.0)
        return SessionTraces(
            "live" if live else "simulated",
            duration_s,
            users,
            self._server(scenario) if self._steps else None,
            self._links(scenario) if scenario else {},
        )

    def _seconds(self, times_ns: Any) -> Array:
        return (np.asarray(times_ns, dtype=np.float64) - self.zero_ns) / NS

    def _user(self, name: str, blocks: list[TraceBlock]) -> UserTraces:
        period_ns = blocks[-1].period_ns
        at_ns = [each.start_ns + period_ns * np.arange(each.ticks) for each in blocks]
        times_ns = np.concatenate(at_ns)
        whole = np.concatenate([each.signals for each in blocks], axis=1)
        of = dict(zip(SIGNALS, whole, strict=True))
        sums = [each.sums for each in blocks]
        up, work = ([getattr(s, key) if s else 0.0 for s in sums] for key in ("up", "device"))
        return UserTraces(
            name=name,
            tick_s=period_ns / NS,
            time_s=self._seconds(times_ns),
            tick=np.rint(times_ns / period_ns).astype(np.int64),
            **of,
            f_m=of["f_applied"],
            u_m_lp=of["u_m"],
            lateness_s=np.concatenate([each.lateness_s for each in blocks]),
            compute_s=np.zeros(len(times_ns)),
            block_time_s=self._seconds([each.end_ns + period_ns for each in blocks]),
            state=np.array([each.state for each in blocks]),
            reason=[each.reason for each in blocks],
            energy={"u_tx": np.array(up), "device": np.array(work)},
        )

    def _server(self, scenario: Scenario | None) -> ServerTraces:
        steps, rows = list(self._steps), len(self._steps)
        times_s = self._seconds([each.start_ns for each in steps])
        usual_s = float(np.median(np.diff(times_s))) if rows > 1 else 0.0
        period_s = scenario.server.period_s if scenario else usual_s
        bodies = np.stack([each.object for each in steps], axis=1)
        avatars = np.stack([each.avatars for each in steps], axis=2)  # (signal, user, step, dof)
        there = range(avatars.shape[1])
        sums = [[each.sums.get(name) for each in steps] for name in self._users]
        nothing = np.zeros(rows)
        return ServerTraces(
            users=list(self._users),
            periods_s=np.full(rows, period_s),
            time_s=times_s,
            step=np.rint(times_s / period_s).astype(np.int64) if period_s else np.arange(rows),
            **dict(zip(OBJECT, bodies, strict=True)),
            x_s=list(avatars[AVATAR.index("x_s")]),
            xd_s=list(avatars[AVATAR.index("xd_s")]),
            f_s=list(avatars[AVATAR.index("f_s")]),
            u_s=[np.zeros_like(avatars[0, user]) for user in there],
            v_s=[np.zeros_like(avatars[0, user]) for user in there],
            contact=[np.array([each.contact[user] for each in steps]) for user in there],
            state=[np.array([each.state[user] for each in steps]) for user in there],
            energy_u_s=[np.array([s.u_s if s else 0.0 for s in each]) for each in sums],
            energy_v_s=[np.array([s.v_s if s else 0.0 for s in each]) for each in sums],
            kinetic=nothing,
            potential=nothing,
            dissipated=nothing,
        )

    def _links(self, scenario: Scenario) -> dict[str, PacketTraces]:
        found = {}
        for link, kept in enumerate(self._packets):
            if not kept:
                continue
            user = scenario.users[link // 2]
            topic = f"/{user.name}/wave_down" if link % 2 else f"/server/{user.name}/wave_up"
            due_s = scenario.server.period_s if link % 2 else user.master.frame_s
            rows = np.concatenate(kept)
            count, none = len(rows), np.zeros((len(rows), 1))
            found[topic] = PacketTraces(
                topic=topic,
                time_s=self._seconds(rows[:, OUT]),
                epoch=np.zeros(count, dtype=np.uint64),
                seq=rows[:, SEQ].astype(np.int64),
                sent_ns=np.zeros(count, dtype=np.int64),
                period_s=np.full(count, due_s),
                wave=none,
                integral=none,
                energy=np.zeros(count),
                position=none,
            )
        return found
