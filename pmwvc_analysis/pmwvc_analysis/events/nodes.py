# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Events of a node: what safety limits do to a device (damping, release, fault, limited force),
restarts and stalls of its loop, and who joins, leaves, grips and is released, with the cause.
"""

import itertools
from collections.abc import Iterator
from operator import itemgetter
from typing import Any

import numpy as np

from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.felt import touching
from pmwvc_analysis.traces.sums import runs
from pmwvc_core.frame import Presence
from pmwvc_core.master.safety import BRAKING, UNCOUPLED, SafetyState
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces, loads
from pmwvc_core.words import listed

Event = dict[str, Any]
STARTING, COUPLED, DAMPING, FAULT = SafetyState
LIMITS = ("force ramps up from zero", "", "safety limits", "safety fault")  # by state
DIGITS = {"N": 2, "N m": 4}
RELEASED = "released"  # in the reason, once damping itself has been released


def event(time_s: float | None, who: str, kind: str, what: str) -> Event:
    """Return an event; kinds: docs/file_format.md."""
    at_s = None if time_s is None else round(float(time_s), 6)
    return {"time_s": at_s, "who": who, "kind": kind, "what": what}


def of_master(user: UserTraces, scenario: Scenario | None) -> Iterator[Event]:
    """Yield changes of safety, stretches of limited force, restarts and stalls of one master."""
    who, coupled, lost = f"{user.name} master", False, False
    blocks = zip(user.state.tolist(), user.reason, user.block_time_s.tolist(), strict=True)
    for (state, reason), same in itertools.groupby(blocks, key=itemgetter(0, 1)):
        time_s = next(same)[2]
        if state == COUPLED:
            if lost:
                yield event(time_s, who, "damping", "force restored in full")
            coupled, lost = True, False
        elif state != STARTING or (coupled and not lost):
            lost, released = True, state == FAULT or RELEASED in reason
            what = f"{LIMITS[state]}: {reason or 'no reason given'}"
            what = reason if reason == UNCOUPLED else what
            yield event(time_s, who, "release" if released else "damping", what)
    for load, unit, ticks, asked, applied in limited(user, scenario):
        for first, last in runs(ticks, user.time_s, th.JOIN_S):
            most, given = (float(size[first : last + 1].max()) for size in (asked, applied))
            length_s = float(user.time_s[last] - user.time_s[first] + user.tick_s)
            limited_s = float(ticks[first : last + 1].sum() * user.tick_s)
            times = f"{limited_s:.3f} s" + f" of {length_s:.3f} s" * (length_s > limited_s + 1e-9)
            wanted, had = (f"{size:.{DIGITS[unit]}f} {unit}" for size in (most, given))
            what = f"{load} limited for {times}: up to {wanted} commanded, {had} applied"
            yield event(float(user.time_s[first]), who, "limit", what)
    again = [user.block_time_s[row : row + 2] for row in np.flatnonzero(np.diff(user.epoch))]
    yield from _breaks(who, "ticks", user.time_s, user.tick_s, holes.of_user(user), again)


def limited(user: UserTraces, scenario: Scenario | None) -> Iterator[tuple[Any, ...]]:
    """Yield name and unit of force and torque, ticks of limits, sizes asked for and applied."""
    rows = zip(loads(user.f_m, scenario), loads(user.f_applied, scenario), strict=True)
    for (load, unit, asked), (_, _, applied) in rows:
        with np.errstate(invalid="ignore", over="ignore"):
            parts = asked, applied, asked - applied
            wanted, given, off = (np.linalg.norm(part, axis=-1) for part in parts)
            large = off > th.LIMITED_RATIO * wanted + th.LIMITED[unit]
        yield load, unit, unbraked(user) & large, wanted, given


def unbraked(user: UserTraces) -> Flags:
    """Tell in which ticks a coupled device was to have the controller's force and no more: where
    it brakes it has more, which no limit made.
    """
    block = holes.block_of_ticks(user)
    brakes = np.array([reason == BRAKING for reason in user.reason], dtype=bool)
    whole = (user.state == COUPLED) & ~brakes
    return np.asarray(whole[block] & whole[np.maximum(block - 1, 0)])


def _breaks(
    who: str, what: str, time_s: Array, period_s: float, lost: list[holes.Unjudged],
    again: list[Array],
) -> Iterator[Event]:  # fmt: skip
    """Yield starts anew, and pauses of a loop that no hole of the recording explains."""
    known = [(hole.start_s, hole.end_s) for hole in lost]
    for end_s, again_s in again:
        yield event(again_s, who, "restart", "started again")
        known.append((float(end_s), float(again_s)))
    for start_s, end_s in holes.pauses(time_s, period_s, known):
        text = f"no {what} for {end_s - start_s - period_s:.3f} s: the loop did not run"
        yield event(start_s, who, "stall", text)


def of_server(
    server: ServerTraces, traces: SessionTraces, scenario: Scenario | None
) -> Iterator[Event]:
    """Yield who joined, left or fell silent, contacts, restarts and stalls of the server."""
    holds = scenario is not None and any(u.contact.grips for u in scenario.users)
    found = holes.of_server(server), [server.time_s[n - 1 : n + 1] for n in holes.starts(server)]
    yield from _breaks("server", "steps", server.time_s, server.period_s, *found)
    for index, name in enumerate(server.users):
        packets = traces.packets.get(f"/server/{name}/wave_up")
        came_s = np.zeros(0) if packets is None else packets.time_s
        yield from _presence(server, index, traces.duration_s, came_s)
        made = "grip" if holds else "contact"
        yield from _contacts(server, index, traces.duration_s, made, scenario)


def _presence(
    server: ServerTraces, index: int, duration_s: float, came_s: Array
) -> Iterator[Event]:
    """Yield changes of a user at the server, whose packets came at some times [s]. The avatar is
    damped where no packets come, and where the user is known to receive none.
    """
    name, state = server.users[index], server.state[index]
    before: int = Presence.ABSENT
    again = holes.starts(server)
    changed = (np.flatnonzero(np.diff(state)) + 1).tolist()
    for row in sorted({0, *changed, *again}) if len(state) else []:
        now, time_s = int(state[row]), float(server.time_s[row])
        before = Presence.ABSENT if row in again else before
        if now == before or time_s > duration_s - th.END_S:
            continue
        if now == Presence.ABSENT:
            yield event(time_s, name, "leave", "left the server")
        elif before == Presence.ABSENT:
            yield event(time_s, name, "join", "joined at the server")
        elif now == Presence.DAMPING:
            newest_s = came_s[came_s <= time_s].max(initial=-np.inf)
            silent = time_s - newest_s > th.STALL_PERIODS * server.period_s
            lost = "no packets reach the server" if silent else "the user receives no packets"
            yield event(time_s, name, "damping", f"{lost}: the avatar is only damped")
        elif before == Presence.DAMPING:
            yield event(time_s, name, "damping", "the avatar is coupled again")
        before = now


def _contacts(
    server: ServerTraces, index: int, duration_s: float, made: str, scenario: Scenario | None
) -> Iterator[Event]:
    name = server.users[index]
    for first, last in runs(touching(server, index), server.time_s, th.DEBOUNCE_S):
        parts = loads(server.f_s[index][first : last + 1], scenario)
        most = [(float(np.nanmax(np.linalg.norm(f, axis=-1))), unit) for _, unit, f in parts]
        sizes = [f"{size:.{DIGITS[unit]}f} {unit}" for size, unit in most]
        start, end = float(server.time_s[first]), float(server.time_s[last]) + server.period_s
        yield event(start, name, made, f"contact made; up to {listed(sizes)} until {end:.2f} s")
        if end < min(duration_s, float(server.time_s[-1])) - th.END_S:
            yield event(end, name, "release", "contact lost")
