# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What slips in a grip, and what falls: from the poses, contacts and forces on record.

A grip is a body that two users touch at once. In its axes R at c a user's part at x that sticks
to it with the force F stays at::

    q = R^T (x - c - F/K)

with the stiffness K of the user's contact; environments with contacts of their own have none, and
these are taken as rigid. A body slips while q moves, and falls while nobody touches it and it goes
down.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pmwvc_analysis.events.nodes import Event, event
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.felt import touching
from pmwvc_analysis.traces.sums import runs, spans
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces
from pmwvc_core.words import listed


def events(
    server: ServerTraces | None, scenario: Scenario | None, scene: Mapping[str, Any]
) -> Iterator[Event]:
    """Yield a ``slip`` of a body in a grip, and a ``drop`` of one that falls after a touch."""
    if scenario is None or server is None or not len(server.time_s):
        return
    held = {each["user"]: each["body"] for each in scene.get("shapes", ()) if each["user"] >= 0}
    parts = {user: part for user, part in held.items() if part in server.poses}
    bodies = [body for body in server.poses if body not in parts.values()]
    compliance = [
        scenario.environment.contact_law / user.contact.contact_stiffness
        for user in scenario.users
    ]
    for body in bodies if parts else ():
        alone = len(bodies) == 1
        touches = {u: _touches(server, u, part, body, alone) for u, part in parts.items()}
        q = [_place(server, u, part, body, compliance[u]) for u, part in parts.items()]
        names = [server.users[user] for user in parts]
        yield from _slips(server, body, names, np.stack(list(touches.values())), np.stack(q))
        yield from _falls(server, body, np.any(list(touches.values()), axis=0))


def _touches(server: ServerTraces, user: int, part: str, body: str, alone: bool) -> Flags:
    """Tell at which steps a user's part touches a body: by the contacts on record, or, without
    any, by its force, where that can be on one body only. Contact that is soon made again stays.
    """
    found = np.zeros(len(server.time_s), dtype=bool)
    if len(server.contacts):
        pair = sorted(map(list(server.poses).index, (part, body)))
        found[
            server.contacts[(np.sort(server.contacts[:, 1:3]) == pair).all(1), 0].astype(int)
        ] = 1
    elif alone:
        found |= touching(server, user)
    for first, last in runs(found, server.time_s, th.DEBOUNCE_S):
        found[first:last] = True
    return found


def _place(server: ServerTraces, user: int, part: str, body: str, compliance: float) -> Array:
    """Return q ``(step, 3)`` [m]."""
    force = np.nan_to_num(server.f_s[user][:, :3])
    bent = np.pad(compliance * force, [(0, 0), (0, 3 - force.shape[1])])
    away = server.poses[part][:, :3] - server.poses[body][:, :3] - bent
    turned = np.roll(server.poses[body][:, 3:], -1, axis=1)
    return np.asarray(Rotation.from_quat(turned).inv().apply(away))


def _slips(
    server: ServerTraces, body: str, names: list[str], touches: Flags, q: Array
) -> Iterator[Event]:
    """Yield what slips by more than ``SLIPS_M`` at once; arrays are ``(user, step, ...)``."""
    gripped = touches.sum(axis=0) >= 2
    both = touches[:, :-1] & touches[:, 1:] & gripped[:-1] & gripped[1:]
    steps = np.diff(q, axis=1)
    speeds = np.linalg.norm(steps, axis=-1) / np.diff(server.time_s)
    slides = both & (speeds > th.SLIDES_M_S)
    steps[~slides] = 0.0
    for first, last in runs(slides.any(axis=0), server.time_s[:-1], th.JOIN_S):
        end = last + 1
        ways = np.linalg.norm(steps[:, first:end].sum(axis=1), axis=-1)
        if ways.max() > th.SLIPS_M:
            whose = listed([n for n, way in zip(names, ways, strict=True) if way > th.SLIPS_M])
            out = "" if gripped[end : end + 3].all() else ", and out of it"
            until = f"until {server.time_s[end]:.2f} s"
            what = f"slipped by {1e3 * ways.max():.1f} mm in the grip of {whose} {until}{out}"
            yield event(server.time_s[first], body, "slip", what)


def _falls(server: ServerTraces, body: str, touched: Flags) -> Iterator[Event]:
    height = server.poses[body][:, 2]
    for free in spans(~touched):
        fell_m = float(height[free][0] - height[free].min())
        if free.start > 0 and fell_m > th.SLIPS_M:
            what = f"fell by {1e3 * fell_m:.1f} mm, touched by no user"
            yield event(server.time_s[free.start], body, "drop", what)
