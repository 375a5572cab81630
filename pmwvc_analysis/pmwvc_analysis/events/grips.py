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

from pmwvc_analysis.events.nodes import Event, event
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.sums import runs, spans
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.quaternions import IDENTITY
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces
from pmwvc_core.words import listed


def events(
    server: ServerTraces | None, scenario: Scenario | None, scene: Mapping[str, Any]
) -> Iterator[Event]:
    """Yield a ``slip`` of a body in a grip, and a ``drop`` of one that falls after a touch."""
    if scenario is None or server is None or not len(server.time_s):
        return
    shown = {each.get("user", -1): each["body"] for each in scene.get("shapes", ())}
    there = [(n, user) for n, user in enumerate(scenario.users) if user.name in server.users]
    parts = [(user, shown[n]) for n, user in there if shown.get(n) in server.poses]
    bodies = server.poses.keys() - {part for _, part in parts}
    own_law = not scenario.environment.contact_law
    for body in sorted(bodies) if parts else ():
        touches, q = [], []
        for user, part in parts:
            index = server.users.index(user.name)
            stiffness = np.inf if own_law else user.contact.contact_stiffness
            touches.append(_touches(server, part, body))
            q.append(_place(server, index, part, body, stiffness))
        names = [user.name for user, _ in parts]
        yield from _slips(server, body, names, np.stack(touches), np.stack(q))
        yield from _falls(server, body, np.any(touches, axis=0))


def _touches(server: ServerTraces, *pair: str) -> Flags:
    """Tell at which steps two bodies touch by record; contact that is soon made again stays."""
    found = np.zeros(len(server.time_s), dtype=bool)
    both = np.sort(server.contacts[:, 1:3]) == sorted(map(list(server.poses).index, pair))
    found[server.contacts[both.all(axis=1), 0].astype(int)] = True
    for first, last in runs(found, server.time_s, th.DEBOUNCE_S):
        found[first:last] = True
    return found


def _place(server: ServerTraces, user: int, part: str, body: str, stiffness: float) -> Array:
    """Return q ``(step, 3)`` [m]."""
    from scipy.spatial.transform import Rotation  # takes long to import, and only this needs it

    force = np.nan_to_num(server.f_s[user][:, :3])
    bent = np.pad(force / max(stiffness, 1.0), [(0, 0), (0, 3 - force.shape[1])])
    away = server.poses[part][:, :3] - server.poses[body][:, :3] - bent
    turned = np.roll(server.poses[body][:, 3:], -1, axis=1)
    turned[~(np.linalg.norm(turned, axis=1) > 0.0)] = IDENTITY  # a recording may hold anything
    return np.asarray(Rotation.from_quat(turned).inv().apply(away))


def _slips(
    server: ServerTraces, body: str, names: list[str], touches: Flags, q: Array
) -> Iterator[Event]:
    """Yield what slips by more than ``SLIPS_M`` at once, but in the hands of users who let go of
    what others hold; arrays are ``(user, step, ...)``.
    """
    gripped = touches.sum(axis=0) >= 2
    both = touches[:, :-1] & touches[:, 1:] & gripped[:-1] & gripped[1:]
    steps = np.diff(q, axis=1)
    slides = both & (np.linalg.norm(steps, axis=-1) > th.SLIDES_M_S * np.diff(server.time_s))
    for first, last in runs(slides.any(axis=0), server.time_s[:-1], th.JOIN_S):
        after = slice(last + 1, last + 4)
        kept = gripped[after].all()
        own = slides[:, first : last + 1] & (touches[:, after].all(axis=1, keepdims=True) | ~kept)
        way = np.sum(steps[:, first : last + 1], axis=1, where=own[..., None])
        ways_m = np.linalg.norm(way, axis=-1)
        if ways_m.max() > th.SLIPS_M:
            whose = listed([n for n, way in zip(names, ways_m, strict=True) if way > th.SLIPS_M])
            until = f"until {server.time_s[last + 1]:.2f} s{'' if kept else ', and out of it'}"
            what = f"slipped by {1e3 * ways_m.max():.1f} mm in the grip of {whose} {until}"
            yield event(server.time_s[first + np.argmax(own.any(axis=0))], body, "slip", what)


def _falls(server: ServerTraces, body: str, touched: Flags) -> Iterator[Event]:
    height = server.poses[body][:, 2]
    for free in spans(~touched):
        fell_m = float(height[free][0] - height[free].min())
        if free.start > 0 and fell_m > th.SLIPS_M:
            what = f"fell by {1e3 * fell_m:.1f} mm, touched by no user"
            yield event(server.time_s[free.start], body, "drop", what)
