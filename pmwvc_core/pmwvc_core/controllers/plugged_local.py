# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A local model of another package: what a factory ``LocalModelParams -> model`` makes, the entry
point of a name in the group ``pmwvc.local_models``. A class for the server's environments fits
(:class:`pmwvc_core.server.black_box.BlackBox`): signals are arrays ``(1, dof)``, one user.

With ``local(position, dt) -> (F0, G)`` the loop is solved, and F0 + G xd at the middle of the tick
is the force. Without, the force is that of the tick before, which can make energy: while more has
come back than went in, the port is a matched damper, v2 = 0, so its deficit is at most what one
tick gave out. A model that fails is a matched damper from then on; the reason is logged once.
"""

import logging
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pmwvc_core.law.port import filter_bank
from pmwvc_core.law.vectors import Vector, dot, plus, scaled, zero
from pmwvc_core.params import LocalModelParams
from pmwvc_core.plugins import BadAnswer, Faults, PluginGroup
from pmwvc_core.server.contained import LARGEST_N, signal

PLUGINS = PluginGroup(
    "pmwvc.local_models",
    "master.local_model.kind",
    "a local model",
    calls=("step",),
    own=("spring_damper",),
)
R = TypeVar("R")
logger = logging.getLogger(__name__)


class PluggedLocalParams(NamedTuple):
    """Names the model; the slope of a matched damper [N s/m]; where it is in place; the tick."""

    params: LocalModelParams
    matched: float
    acts: int
    begins_m: float
    tick_s: float


class PluggedLocal(NamedTuple):
    """The model, which keeps a state of its own, and its port; at rest at zero at first."""

    model: Any
    faults: Faults  # one puts it out of use
    x: Vector  # [m]
    f: Vector  # [N] as it answered last
    f0: Vector  # [N] of this tick
    slope: float  # [N s/m]
    there: bool
    stored_j: float  # what went in and has not come back
    dissipated_j: float


@filter_bank.resting_local.member(PluggedLocalParams)
def _resting(p: PluggedLocalParams, axes: int) -> PluggedLocal:
    """Make the model; ParameterError if there is no such entry point, or it leads to none."""
    rest = (0.0,) * axes
    faults = Faults(PLUGINS.parameter, p.params.kind)
    model = PLUGINS.make(p.params.kind, p.params)
    return PluggedLocal(model, faults, rest, rest, rest, 0.0, True, 0.0, 0.0)


def _asked(s: PluggedLocal, ask: Callable[[], R]) -> R | None:
    """Return what a model answers; None, and it is out of use, where it fails."""
    answer = s.faults.guarded(ask, None)
    if answer is None:
        logger.error("%s; a matched damper replaces it", s.faults.text)
    return answer


def _force(answer: Any, like: Vector) -> Vector:
    """Return an answer as a law's signal; BadAnswer if it is no finite force of that length."""
    force = signal(answer, (1, len(like)))
    if not (np.abs(force) <= LARGEST_N).all():  # false for NaN
        raise BadAnswer("returned no usable force (not finite, or beyond 1e6 N)")
    return tuple(force[0].tolist())


@filter_bank.local_offered.member(PluggedLocal)
def _offered(s: PluggedLocal, device_x: Vector, p: PluggedLocalParams) -> PluggedLocal:
    """Have the model's F0 and G, or those of a matched damper."""
    there = filter_bank.is_there(device_x, p.acts, p.begins_m)
    f0, slope, model = s.f, 0.0, s.model

    def line() -> tuple[Vector, Vector]:
        at_rest, slopes = model.local(np.array([s.x]), 0.5 * p.tick_s)
        return _force(at_rest, s.x), _force(slopes, s.x)

    if hasattr(model, "local") and not s.faults.steps:
        if answer := _asked(s, line):
            f0, slope = answer[0], max(*answer[1], 0.0)
    if s.faults.steps or s.stored_j < 0.0:
        f0, slope = zero(s.x), p.matched
    if not there:
        f0, slope = zero(s.x), 0.0
    return s._replace(f0=f0, slope=slope, there=there)


@filter_bank.local_moved.member(PluggedLocal)
def _moved(s: PluggedLocal, f: Vector, xd: Vector, p: PluggedLocalParams) -> PluggedLocal:
    """Count what went in, and let the model go on."""
    x, stored_j = plus(s.x, scaled(xd, p.tick_s)), s.stored_j + dot(f, xd) * p.tick_s
    s = s._replace(x=x, stored_j=stored_j)
    if s.faults.steps:
        return s
    signals = np.array([x]), np.array([xd])
    answer = _asked(s, lambda: _force(s.model.step(*signals, p.tick_s), x))
    return s._replace(f=answer) if answer else s


filter_bank.local_stored_j.member(PluggedLocal)(lambda s, p: s.stored_j)
# the model has its numbers from when it was made
filter_bank.changed_local.member(PluggedLocal)(lambda s, old, p: s)
