# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Events of membership and contact: join, leave, restart, stall, grip, release with its cause."""

from collections.abc import Iterator

import numpy as np

from pmwvc_analysis.events.event import Event, changes, event
from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces.felt import touching
from pmwvc_analysis.traces.reductions import runs
from pmwvc_analysis.traces.server_starts import starts
from pmwvc_core.frame.rows import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

ABSENT, DAMPING = Presence.ABSENT, Presence.DAMPING
COUPLED_MASTER = 1
STALL_S = 0.02  # a pause of a loop this long is an event
STEPS = 2.5  # and this many periods
DEBOUNCE_S = 0.05  # contact that is lost for less than this was not lost
APART_M = 2e-3  # a device moves on by less while its first packet is under way
CAUSE_S = 0.3  # how long before a release its cause is looked for
MOST = 20
END_S = 0.1


def of_master(user: UserTraces) -> Iterator[Event]:
    """Yield restarts and stalls of one master."""
    who = f"{user.name} master"
    gaps = [(hole.start_s, hole.end_s) for hole in holes.of_user(user)]
    for row in changes(user.epoch):
        end_s, again_s = user.block_time_s[row - 1 : row + 1].tolist()
        yield event(end_s, who, "restart", "started again")
        gaps.append((end_s, again_s))
    yield from _stalls(who, "ticks", user.time_s, user.tick_s, gaps)


def _stalls(
    who: str, what: str, time_s: Array, period_s: float, known: list[tuple[float, float]]
) -> Iterator[Event]:
    """Yield pauses of a loop that no hole of the recording explains."""
    pauses = np.diff(time_s)
    rows = np.flatnonzero(pauses > max(STALL_S, STEPS * period_s))
    found = [
        row
        for row in rows.tolist()
        if not any(start < time_s[row + 1] and time_s[row] < end for start, end in known)
    ]
    for row in found[:MOST]:
        text = f"no {what} for {pauses[row] - period_s:.3f} s: the loop did not run"
        yield event(float(time_s[row]), who, "stall", text)
    if len(found) > MOST:
        text = f"{count(len(found) - MOST, 'more pause')} of {what}"
        yield event(float(time_s[found[MOST]]), who, "stall", text)


def of_server(traces: SessionTraces, *, grips: bool) -> Iterator[Event]:
    """Yield who joined, left or fell silent, contacts, restarts and stalls of the server."""
    server = traces.server
    assert server is not None
    gaps = [(hole.start_s, hole.end_s) for hole in holes.of_server(server)]
    for row in np.flatnonzero(np.diff(server.step) < 0).tolist():
        end_s, again_s = server.time_s[row : row + 2].tolist()
        yield event(again_s, "server", "restart", "started again")
        gaps.append((end_s, again_s))
    yield from _stalls("server", "steps", server.time_s, server.period_s, gaps)
    masters = {user.name: user for user in traces.users}
    for index, name in enumerate(server.users):
        yield from _presence(server, index, masters.get(name), traces.duration_s)
        yield from _contacts(server, index, masters.get(name), traces.duration_s, grips=grips)


def _presence(
    server: ServerTraces, index: int, user: UserTraces | None, duration_s: float
) -> Iterator[Event]:
    name, state = server.users[index], server.state[index]
    before: int = ABSENT
    again = [start.row for start in starts(server)]
    for row in sorted({0, *changes(state), *again}) if len(state) else []:
        now, time_s = int(state[row]), float(server.time_s[row])
        before = ABSENT if row in again else before
        if now == before or time_s > duration_s - END_S:
            continue
        if now == ABSENT:
            yield event(time_s, name, "leave", "left the server")
        elif before == ABSENT:
            text = f"joined at the server{_apart(server, index, user, row)}"
            yield event(time_s, name, "join", text)
        elif now == DAMPING:
            text = "no packets reach the server: the avatar is only damped"
            yield event(time_s, name, "damping", text)
        elif before == DAMPING:
            yield event(time_s, name, "damping", "packets reach the server again")
        before = now


def _apart(server: ServerTraces, index: int, user: UserTraces | None, row: int) -> str:
    """Return the distance of an avatar from its device at a step, where it is worth a word."""
    if user is None or not len(user.time_s):
        return ""
    apart = user.x_m[user.rows_at(server.time_s[row])] - server.x_s[index][row]
    length_m = float(np.linalg.norm(apart))
    return f", {1e3 * length_m:.1f} mm from its device" if length_m > APART_M else ""


def _contacts(
    server: ServerTraces, index: int, user: UserTraces | None, duration_s: float, *, grips: bool
) -> Iterator[Event]:
    name, touches = server.users[index], touching(server, index)
    made = "grip" if grips else "contact"
    found = runs(touches, server.time_s, join_s=DEBOUNCE_S)
    for first, last in found[:MOST]:
        force = float(np.nanmax(np.linalg.norm(server.f_s[index][first : last + 1], axis=-1)))
        start, end = float(server.time_s[first]), float(server.time_s[last]) + server.period_s
        yield event(start, name, made, f"contact made; up to {force:.2f} N until {end:.2f} s")
        if end < min(duration_s, float(server.time_s[-1])) - END_S:
            cause = _cause(server, index, user, end)
            yield event(end, name, "release", f"contact lost: {cause}")
    if len(found) > MOST:
        text = f"{made} made and lost {count(len(found) - MOST, 'more time')}"
        yield event(float(server.time_s[found[MOST][0]]), name, made, text)


def _cause(server: ServerTraces, index: int, user: UserTraces | None, at_s: float) -> str:
    """Return what took a contact away, as far as the traces show it."""
    after = np.searchsorted(server.time_s, at_s)
    if after < len(server.time_s) and server.state[index][after] == ABSENT:
        return "the user left"
    if any(server.time_s[s.last] < at_s <= server.time_s[s.row] for s in starts(server)):
        return "the server was started again"
    near = (server.time_s > at_s - CAUSE_S) & (server.time_s <= at_s)
    if (server.state[index][near] == DAMPING).any():
        return "no packet reached the server"
    if user is not None:
        blocks = (user.block_time_s > at_s - CAUSE_S) & (user.block_time_s <= at_s)
        rows = np.flatnonzero(blocks & (user.state != COUPLED_MASTER))
        if len(rows):
            return f"safety limits: {user.reason[int(rows[-1])] or 'not coupled'}"
    return "avatar and object separated"
