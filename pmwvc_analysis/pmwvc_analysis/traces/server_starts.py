# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Servers that were started again in a session, and the energy sums across such a start.

While no server runs nothing enters the links at its end, and the masters' records go on: the sums
of the server stand still, those of the masters are known, and the balances of the links are judged
all the time. What a server that was killed sent and had not recorded yet is found in its packets,
which carry the energy sent so far.

A new server begins with nothing. What the one before it had received and not used, and what
packets brought while no server ran, no later server may give out (:func:`died_up`); a queue keeps
the last packets that came before a server's first step. At the device the playout discards what it
had of the server before (:func:`discarded`). Neither is left in a balance from the start on, where
it would hide energy that is generated later.

Equations: docs/theory.md 13.12.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.traces.sums import UserSums
from pmwvc_core.master.strict_accounts import DISCARDED
from pmwvc_core.numeric import Array
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces

QUEUE = 64  # packets that wait for a server's first step at most


class ServerStart(NamedTuple):
    """A start after the first: row of the last step before it, its own first row, and time of its
    first step, which may not have been recorded [s].
    """

    last: int
    row: int
    begins_s: float


def starts(server: ServerTraces) -> list[ServerStart]:
    """Return the starts of the server after its first one."""
    found = []
    for last in np.flatnonzero(np.diff(server.step) < 0).tolist():
        row = last + 1
        missing_s = float((server.step[row] - 1) * server.periods_s[row])
        begins_s = max(float(server.time_s[row]) - missing_s, float(server.time_s[last]))
        found.append(ServerStart(last, row, begins_s))
    return found


def instants(server: ServerTraces, times: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the instants at which sums of the server are known, and the row of each.

    These are its steps, at ``times`` [s], and while no server ran every period.
    """
    rows = np.arange(len(times))
    parts, last_rows = [times], [rows]
    for start in starts(server):
        period_s = float(server.periods_s[start.last])
        idle_s = np.arange(times[start.last] + period_s, start.begins_s - 0.5 * period_s, period_s)
        parts.append(idle_s)
        last_rows.append(np.full(len(idle_s), start.last))
    if len(parts) == 1:
        return times, rows
    together = np.concatenate(parts)
    order = np.argsort(together, kind="stable")
    return together[order], np.concatenate(last_rows)[order]


def completed(sums: Array, server: ServerTraces, traces: SessionTraces, user: str) -> Array:
    """Return the sums of v_s with what packets show beyond the last recorded step of a server
    that was killed [J].

    Parameters
    ----------
    sums
        As recorded, going on across starts ``(step,)``.
    """
    sent = [traces.packets.get(f"{end}/{user}/wave_down") for end in ("/server", "")]
    sums, begun, since_s = sums.copy(), 0.0, -np.inf
    for start in starts(server):
        last = float(sums[start.last])
        shown = begun + max(_largest(each, since_s, start.begins_s) for each in sent)
        if shown > last:
            sums[start.row :] += shown - last
        begun, since_s = max(shown, last), start.begins_s
    return sums


def died_up(
    times: Array, server: ServerTraces, traces: SessionTraces, user: str, taken: Array
) -> Array:
    """Return the energy of a user's packets that no server used or will use, at some instants [J].

    Parameters
    ----------
    taken
        Energy that the servers took, going on across starts ``(step,)`` [J].
    """
    found = np.zeros(len(times))
    packets = traces.packets.get(f"/server/{user}/wave_up")
    if packets is None or _again(packets):
        return found
    for start in starts(server):
        idle = packets.energy[packets.time_s < start.begins_s][:-QUEUE]
        if len(idle):
            gone = max(float(idle.max()) - float(taken[start.last]), 0.0)
            after = times >= start.begins_s
            found[after] = np.maximum(found[after], gone)
    return found


def discarded(times: Array, server: ServerTraces, traces: SessionTraces, sums: UserSums) -> Array:
    """Return what the playout of a device has discarded, from a server's second start on [J]."""
    given_up = sums.user.accounts.get(DISCARDED.name)
    packets = traces.packets.get(f"/server/{sums.user.name}/wave_up")
    again = starts(server)
    if not again or given_up is None or packets is None or _again(packets):
        return np.zeros(len(times))
    known = sums.of_blocks(given_up, after_s=np.inf)
    return np.where(times >= again[0].begins_s, known, 0.0)


def _again(packets: PacketTraces) -> bool:
    """Tell whether the user was started again as well."""
    return len(np.unique(packets.epoch)) > 1


def _largest(packets: PacketTraces | None, since_s: float, until_s: float) -> float:
    """Return the largest energy that packets of an interval carried [J]."""
    if packets is None:
        return 0.0
    rows = (packets.time_s > since_s) & (packets.time_s < until_s)
    return float(packets.energy[rows].max(initial=0.0))
