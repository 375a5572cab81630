# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session simulator as a linear loop: no limits, no hand but forces that are given.

The simulator's own objects run; only the safety limits let everything through, receivers refuse no
wave for its size, and hands are rows of forces. This is the other route by which the models are
checked.
"""

import dataclasses
import math

import numpy as np

from pmwvc_analysis.models.loop import held
from pmwvc_analysis.models.response import OUTPUTS
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import LIVE
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import SteppedSession

SETTLED = 200  # ticks after which every user has joined, whatever the delay here


class Wire:
    """In the place of the safety limits of a plug-in's end: everything passes."""

    ready = True
    state = 0
    reason = ""
    events = 0

    def step(self, f_asked, x, xd, silence_s, coupled, *_):
        return f_asked

    def expect(self, silence_s):
        """Take no notice."""


def opened(end, x_m):
    """Let every force of a user's end through from the first tick on, and take positions, which
    begin at x_m [m], as exact.
    """
    if not isinstance(end, UserEnd):
        end.safety = Wire()
        return
    p, s = end.p.limits, end.s
    endless = {name: math.inf for name in p._fields if isinstance(getattr(p, name), float)}
    limits = p._replace(**endless | {"soft_start_s": 1e-9, "tick_s": p.tick_s, "brakes": False})
    end.p = end.p._replace(limits=limits)
    port = s.port
    if hasattr(port, "counts"):
        exact = tuple(resting_counts(x)._replace(step_m=0.0) for x in x_m)
        port = port._replace(x=x_m, counts=exact, begun=True)
    end.s = s._replace(limits=s.limits._replace(ready=True), port=port)


def scenario(**overrides):
    """Two users, one cube, waves; ``overrides`` by dotted name with ``__`` for the dots."""
    return parse_scenario(
        {
            "name": "loop",
            "duration_s": 1.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 2,
            "master": {"filter": {"kind": "first_order", "pole_rad_s": 50.0}, "hold": "zoh"},
            "device": {"workspace_m": 1e9},
            "safety": {"timeout_s": 5.0},
            "operator": {"kind": "none"},
            "server": {"contact": "bilateral", "contact_damping": 10.0},
            "task": {"kind": "free"},
        },
        overrides={name.replace("__", "."): value for name, value in overrides.items()},
    )


def simulated(of, forces, *, live=False, on_step=None, before=lambda batch: None):
    """Return traces under the given forces ``(users, ticks)``, or ``(users, ticks, dof)``, which
    begin after ``SETTLED``; ``on_step`` is called with the server behind each of its steps,
    ``before`` with the session before it runs.
    """
    ticks = SETTLED + forces.shape[1]
    batch = SteppedSession(
        dataclasses.replace(of, duration_s=ticks * of.tick_s),
        Conditions(schedule=LIVE) if live else Conditions(),
    )
    for user, row in zip(batch.users, forces, strict=True):
        opened(user.loop, user.device.s.x)
        for link in (user.up, user.down):  # a loop that grows passes every legal wave
            link.receiver.max_wave = math.inf
        push = row.reshape(len(row), -1)
        force = np.concatenate([np.zeros((SETTLED, push.shape[1])), push])
        p = recorded_params(force, of.dof, repeat=False, early=False)
        user.device.hand, user.device._of_hand = RecordedForce(0), p
    if on_step:
        noted = batch._note_step
        batch._note_step = lambda *row: (noted(*row), on_step(batch.server))
    before(batch)
    batch.run(lambda share: None)
    return batch.traces()


def modelled(model, forces):
    """Return x, xd and f by the model, from rest under the given forces; all of them
    ``(users, ticks)``, or ``(users, ticks, dof)``.
    """
    users, ticks, axes = len(model.scenario.users), model.ticks, forces.shape[2:]
    states, (matrix,) = held(model)
    n = len(states)
    frames = -(-forces.shape[1] // ticks)
    padded = np.zeros((users, frames * ticks, *axes))
    padded[:, : forces.shape[1]] = forces
    state, read = np.zeros(n), []
    for frame in range(frames):
        f = padded[:, frame * ticks : (frame + 1) * ticks].ravel()
        after = matrix @ np.concatenate([state, f])
        state = after[:n]
        read.append(after[n + model.sent :].reshape(users, len(OUTPUTS), ticks, *axes))
    found = np.concatenate(read, axis=2)[:, :, : forces.shape[1]]
    return {name: found[:, place] for place, name in enumerate(OUTPUTS)}
