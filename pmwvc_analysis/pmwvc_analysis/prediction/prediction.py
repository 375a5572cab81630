# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The prediction for a scenario: stability, aliasing, and the rendering of the link.

Stability and spectral radius are those of the exact model (:mod:`pmwvc_analysis.models`): hands
off, all contacts touching, every packet after its constant delay. A nonlinear scenario has no such
model; then stability is predicted only by a proof for any constant delay
(:mod:`pmwvc_analysis.models.any_delay`), and only if the nearest linear scenario does not
contradict it. Lag, stiffness and mass: :mod:`pmwvc_analysis.prediction.lag`.
"""

import contextlib
import functools
from typing import Any, NamedTuple

from pmwvc_analysis.models.answer import Exact, exact
from pmwvc_analysis.models.any_delay import AnyDelay, any_delay
from pmwvc_analysis.models.linear import Relative, left_out, relative
from pmwvc_analysis.prediction import environment
from pmwvc_analysis.prediction.lag import lag_decides, lag_s, rendered_mass, rendered_stiffness
from pmwvc_core.controllers.library import proofs_hold
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave import aliasing

ALIASING_BOUND = 1.1  # aliasing gain above which a warning is given


class StabilityAnswer(NamedTuple):
    """Everything known about the stability of a scenario."""

    near: Relative | None  # the nearest linear scenario, of one that is not linear
    model: Exact | None  # the exact model of it, or of a scenario that is linear itself
    unknown: str  # why that has no answer; empty where it has one
    at_any_delay: AnyDelay | None  # None: without waves
    limited: bool | None  # whether a server port will limit its environment; None: not known

    @property
    def exact(self) -> Exact | None:
        """The exact model of the scenario itself; None where it has none."""
        return self.model if self.near is None else None

    @property
    def proved(self) -> bool:
        """Tell whether stability at any constant delay is proved, and no model contradicts it."""
        proof = self.at_any_delay is not None and self.at_any_delay.proved
        contradicted = self.model is not None and not self.model.stable
        return proof and self.limited is False and not contradicted

    @property
    def stable(self) -> bool | None:
        """The prediction; None where there is none."""
        if self.exact is not None:
            return self.exact.stable
        return True if self.proved else None


@functools.lru_cache(maxsize=64)
def answer(scenario: Scenario, *, live: bool) -> StabilityAnswer:
    """Return everything known about the stability of a scenario."""
    near = relative(scenario)
    model, unknown = None, ""
    try:
        model = exact(near.scenario if near else scenario, live=live)
    except PmwvcError as error:
        unknown = str(error)
    proof = any_delay(scenario, live=live)
    return StabilityAnswer(near, model, unknown, proof, environment.limited(scenario))


def growth_per_s(scenario: Scenario, *, live: bool) -> float | None:
    """Return the growth of the slowest motion [1/s], negative: decay; None without a model."""
    with contextlib.suppress(PmwvcError):
        return exact(scenario, live=live).growth_per_s
    return None


def prediction(scenario: Scenario, *, live: bool) -> dict[str, Any]:
    """Return the ``prediction`` of a summary; the user who is worst off counts.

    ``spectral_radius`` and ``stable`` are None where there is no exact model (but ``stable`` is
    True where ``any_delay``, the proof, holds). ``loop_gain`` is the largest gain once around
    the loop (None without waves or such a gain), ``k_felt`` and ``mass_felt`` are None where more
    than the lag decides them, ``left_out`` are the effects of links that no prediction has.
    """
    found, users = answer(scenario, live=live), scenario.users
    model, proof = found.exact, found.at_any_delay
    values: dict[str, Any] = {
        "spectral_radius": model.spectral_radius if model else None,
        "stable": found.stable,
        "any_delay": found.proved if proof else None,
        "loop_gain": proof.gain if proof else None,
        "aliasing_gain": None,
        "k_felt": None,
        "mass_felt": None,
        "environment_limited": None,
        "left_out": left_out(scenario),
    }
    if not proofs_hold(scenario.controller):
        return values
    values["environment_limited"] = found.limited
    values["aliasing_gain"] = max(map(aliasing_gain, users))
    if not found.limited and all(lag_decides(user, scenario) for user in users):
        lags = [lag_s(user, scenario, live=live) for user in users]
        values["k_felt"] = min(map(rendered_stiffness, users, lags))
        values["mass_felt"] = max(rendered_mass(user, scenario, live=live) for user in users)
    return values


def aliasing_gain(user: User) -> float:
    """Return the largest ratio of a packet's energy to that of the wave it samples."""
    master = user.master
    return float(
        aliasing.worst_case_gain(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    )
