# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An environment from outside behind the port of :mod:`pmwvc_core.law.black_box`, contained: where
it does not answer, every port is a damper for that step. It runs interpreted, and keeps its own
state.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.law.black_box.black_box import BlackBoxParams
from pmwvc_core.law.black_box.touched import Reply, Vectors, exchange, solved_line, visited
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.vectors import zero
from pmwvc_core.numeric import Array
from pmwvc_core.server.black_box.containment import Asked, Call
from pmwvc_core.server.black_box.faults import Faults


class Outside(NamedTuple):
    """What is asked, how it is asked, what went wrong, and who is there."""

    asked: Asked
    call: Call
    faults: Faults
    there: tuple[bool, ...]


@visited.member(Outside)
def _visited(
    s: Outside, there: tuple[bool, ...], begins: tuple[bool, ...], positions: Vectors
) -> Outside:
    for user, was in enumerate(s.there):
        if was and (begins[user] or not there[user]):
            s.asked.notify("leave", user)
        if begins[user]:
            s.asked.notify("join", user, np.array(positions[user]))
    return Outside(s.asked, s.call, s.faults, there)


@exchange.member(Outside)
def _exchange(
    s: Outside, avatars: tuple[Avatar, ...], starts: Vectors, velocities: Vectors,
    p: BlackBoxParams,
) -> tuple[Outside, Reply]:  # fmt: skip
    def decode(forces: Array, slopes: Array) -> Array:
        rows = zip(avatars, forces.tolist(), slopes.tolist(), strict=True)
        return np.array([solved_line(a, tuple(f), tuple(g), p.identity) for a, f, g in rows])

    ask = partial(s.asked.exchange, period=p.body.period_s, weight=p.new_s, decode=decode)
    rest = zero(starts[0])
    try:
        reply = s.call(partial(ask, np.array(starts), np.array(velocities)))
    except PLUGIN_ERRORS as error:  # whatever the plug-in raises
        s.faults.note(error)
        return s, Reply(False, velocities, starts, -1.0, rest, rest)
    bad = (not good.all() for good in reply.good)
    s.faults.note_users(bad, "no usable force (not finite, or beyond 1e6 N)")
    x, xd = reply.shown or (rest, rest)
    forces = _rows(np.where(reply.good, reply.force, np.nan))
    stored_j = -1.0 if reply.stored is None else float(reply.stored)
    x, xd = tuple(map(float, x)), tuple(map(float, xd))
    return s, Reply(True, _rows(reply.velocity), forces, stored_j, x, xd)


def _rows(values: Array) -> Vectors:
    return tuple(map(tuple, values.tolist()))
