# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Servers that were started again in a session, and the energy sums across such a start.

The last steps of a server that was killed may be missing in the record: they are a hole. What it
sent in them is read from its packets, or is no less than its users received. What it had received
and not used, what came while none ran, and what the playout at a device discards, is left in no
balance, where it would hide what is generated later (theory.md 13.12).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.traces.block_sums import BlockSums, up_to
from pmwvc_analysis.traces.sums import running
from pmwvc_core.controllers.accounts import DISCARDED
from pmwvc_core.numeric import Array
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces

QUEUE = 64  # packets that wait for a server's first step at most
ROUNDING_J = 1e-9


class ServerStart(NamedTuple):
    """A start after the first: row of the last step before it, its own first row, and time of its
    first step, which may not have been recorded [s].
    """

    last: int
    row: int
    begins_s: float


class KilledServer(NamedTuple):
    """The end of a server before a start: until when it is known to have run [s], and the energy
    of v_s that it and those before it sent to each user [J].
    """

    died_s: float
    sent_j: dict[str, float]


def starts(server: ServerTraces) -> list[ServerStart]:
    """Return the starts of the server after its first one."""
    found = []
    for last in np.flatnonzero(np.diff(server.step) < 0).tolist():
        row = last + 1
        missing_s = float((server.step[row] - 1) * server.periods_s[row])
        begins_s = max(float(server.time_s[row]) - missing_s, float(server.time_s[last]))
        found.append(ServerStart(last, row, begins_s))
    return found


def ran_s(server: ServerTraces, traces: SessionTraces) -> Array:
    """Return when each step ran [s]: its deadline, and its lateness where that is known."""
    late_s = traces.metadata.get("server_lateness_s")
    if late_s is None or len(late_s) != len(server.time_s):
        return server.time_s
    return np.asarray(server.time_s + late_s)


def ends(server: ServerTraces, traces: SessionTraces) -> list[KilledServer]:
    """Return the end of the server before each start, by its record, its packets and its users."""
    found: list[KilledServer] = []
    sent_j, since_s, before = dict.fromkeys(server.users, 0.0), -np.inf, -1
    for start in starts(server):
        died_s = float(ran_s(server, traces)[start.last])
        until_s = start.begins_s - 0.5 * float(server.periods_s[start.last])
        for index, user in enumerate(server.users):
            sums = running(server.energy_v_s[index])
            recorded_j = sums[start.last] - (sums[before] if before >= 0 else 0.0)
            shown_j = float(recorded_j)
            for end in ("/server", ""):
                packets = traces.packets.get(f"{end}/{user}/wave_down")
                if packets is None or not len(packets.time_s):
                    continue
                there = (packets.time_s > since_s) & (packets.time_s < until_s)
                shown_j = max(shown_j, float(packets.energy[there].max(initial=0.0)))
                if end == "/server":  # when they were sent: the recorder may get them later
                    sent_s = packets.sent_ns * 1e-9
                    sent_s = sent_s + float(np.min(packets.time_s - sent_s))
                    died_s = max(died_s, float(sent_s[sent_s < until_s].max(initial=-np.inf)))
            sent_j[user] += max(shown_j, 0.0)
            received_j, received_s = _received(traces, user, until_s)
            if received_j > sent_j[user] + ROUNDING_J:
                sent_j[user], died_s = received_j, max(died_s, received_s)
        found.append(KilledServer(died_s, dict(sent_j)))
        since_s, before = until_s, start.last
    return found


def instants(server: ServerTraces, traces: SessionTraces) -> tuple[Array, NDArray[np.intp]]:
    """Return the instants at which sums of the server are known [s], and the row of each: its
    steps, when they ran, and every period while no server ran.
    """
    times = ran_s(server, traces)
    parts, last_rows = [times], [np.arange(len(times))]
    for start, end in zip(starts(server), ends(server, traces), strict=True):
        period_s = float(server.periods_s[start.last])
        idle_s = np.arange(end.died_s + period_s, start.begins_s - 0.5 * period_s, period_s)
        parts.append(idle_s)
        last_rows.append(np.full(len(idle_s), start.last))
    if len(parts) == 1:
        return times, last_rows[0]
    together = np.concatenate(parts)
    order = np.argsort(together, kind="stable")
    return together[order], np.concatenate(last_rows)[order]


def completed(
    sums: Array, times: Array, server: ServerTraces, traces: SessionTraces, user: str
) -> Array:
    """Return the sums of v_s [J] at ``times``, with what killed servers sent beyond the record."""
    sums = sums.copy()
    for end in ends(server, traces):
        after = times > end.died_s
        if after.any():
            sums[after] += max(end.sent_j[user] - float(sums[after][0]), 0.0)
    return sums


def died_up(
    times: Array, server: ServerTraces, traces: SessionTraces, user: str, taken: Array
) -> Array:
    """Return the energy of a user's packets that no server used or will use, at some instants [J];
    ``taken``: energy that the servers took, going on across starts ``(step,)``.
    """
    found = np.zeros(len(times))
    if (packets := _of_one_start(traces, user)) is None:
        return found
    for start in starts(server):
        idle = packets.energy[packets.time_s < start.begins_s][:-QUEUE]
        if len(idle):
            gone = max(float(idle.max()) - float(taken[start.last]), 0.0)
            after = times >= start.begins_s
            found[after] = np.maximum(found[after], gone)
    return found


def discarded(
    times: Array, server: ServerTraces, traces: SessionTraces, blocks: BlockSums
) -> Array:
    """Return what the playout of a device has discarded, from a server's second start on [J]."""
    given_up, again = blocks.user.accounts.get(DISCARDED.name), starts(server)
    if not again or given_up is None or _of_one_start(traces, blocks.user.name) is None:
        return np.zeros(len(times))
    known = up_to(given_up, blocks.ended(times))
    return np.where(times >= again[0].begins_s, known, 0.0)


def _of_one_start(traces: SessionTraces, user: str) -> PacketTraces | None:
    """Return the packets of a user at the server; None where it was started again as well."""
    packets = traces.packets.get(f"/server/{user}/wave_up")
    return packets if packets is not None and len(np.unique(packets.epoch)) <= 1 else None


def _received(traces: SessionTraces, name: str, until_s: float) -> tuple[float, float]:
    """Return the energy that a user received up to a time [J], and when it had all of it [s]."""
    user = next((each for each in traces.users if each.name == name), None)
    if user is None or "v_rx" not in user.energy:
        return 0.0, -np.inf
    sums = running(user.energy["v_rx"])[user.block_time_s < until_s]
    if not len(sums):
        return 0.0, -np.inf
    last = int(np.argmax(sums))
    return float(sums[last]), float(user.block_time_s[last])
