# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page is told of a session: its description, which stays the same while it runs; and the
exact model's predictions of proposed settings. They are made in a process of their own: an
eigenvalue problem must not hold up snapshots, and still less a force loop.
"""

import asyncio
import multiprocessing
import os
from collections.abc import Collection, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from enum import IntEnum
from functools import partial
from typing import Any

from pmwvc_analysis.prediction.lag import lag_decides, lag_s
from pmwvc_core.controllers.library import has_waves, proofs_hold
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame import Presence
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.runtime.interrupts import held_back
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import place_of
from pmwvc_core.wave.impedance import MatrixImpedance
from pmwvc_view import controls, protocol
from pmwvc_view.controls import Settings
from pmwvc_view.protocol.snapshot import Layout

STATES: Mapping[str, type[IntEnum]] = {"master": SafetyState, "server": Presence, "fate": FateKind}


def describe(
    scenario: Scenario,
    layout: Layout,
    scene: Mapping[str, Any],
    *,
    values: Mapping[str, Any],
    remote: Collection[str],
    can: Collection[str],
    holders: Mapping[str, str | None] | None = None,
    **about: Any,
) -> dict[str, Any]:
    """Return the session message: ``scene`` as its environment describes it; ``values`` those of
    the controls; ``remote`` the users whose handle a page can take; ``can`` the kinds of requests
    that are served; ``holders`` who holds each user's handle. ``about``: ``mode`` is live,
    simulated or recorded, ``duration_s`` None where it goes on until it is ended [s].
    """
    return {
        "kind": "session",
        "version": protocol.VERSION,
        "name": scenario.name,
        "description": scenario.description,
        "controller": scenario.controller,
        "waves": has_waves(scenario.controller),
        "dof": scenario.dof,
        "lever_m": scenario.server.lever_m,
        "object": {"size_m": scenario.server.object_size_m, "carried": scenario.task.moves},
        "scene": {name: scene[name] for name in ("shapes", "fixed", "origin") if name in scene},
        "users": [
            {
                "name": user.name,
                "side": user.side,
                "remote": user.name in remote,
                "holder": (holders or {}).get(user.name),
                "force_limit": user.safety.max_force,
                "workspace_m": user.device.workspace_m,
                "start_m": list(place_of(user, scenario).start),
            }
            for user in scenario.users
        ],
        "controls": controls.to_page(values),
        "states": {node: [each.name.lower() for each in kind] for node, kind in STATES.items()},
        "can": sorted(can),
        **about,
        "heartbeat_s": protocol.HEARTBEAT_S,
        "layout": layout.to_page(),
    }


def moving(scene: Mapping[str, Any]) -> list[str]:
    """Return the bodies of a scene that are drawn and move."""
    bodies = dict.fromkeys(shape["body"] for shape in scene.get("shapes", ()))
    return [body for body in bodies if body not in scene["fixed"]]


def lags(scenario: Scenario, *, live: bool) -> dict[str, float | None]:
    """Return the round trip by the model [s] and the wave impedance [N s/m] of every user, by
    column, for F tau/(2b). None: that does not decide, or the impedance is a matrix.
    """
    found: dict[str, float | None] = {}
    for user in scenario.users:
        decides = proofs_hold(scenario.controller) and lag_decides(user, scenario)
        found[f"{user.name}.lag"] = lag_s(user, scenario, live=live) if decides else None
        matrix = isinstance(user.impedance, MatrixImpedance)
        found[f"{user.name}.impedance"] = None if matrix else user.master.impedance
    return found


NICE = 10  # loops and pages come first


class Predictor:
    """Answers questions one after the other; of those that wait only the newest."""

    def __init__(self, *, live: bool) -> None:
        self._live = live
        self._pool: ProcessPoolExecutor | None = None
        self._busy = asyncio.Lock()
        self._newest = 0

    async def ask(self, scenario: Scenario, values: Settings) -> dict[str, Any] | None:
        """Return the prediction for a scenario with settings; None: a newer question came."""
        self._newest = number = self._newest + 1
        async with self._busy:
            if number != self._newest:
                return None
            if self._pool is None:
                # Not forked: the caller may have threads. Nor under their scheduling class.
                context = multiprocessing.get_context("spawn")
                lower = getattr(os, "nice", int)  # not on every system
                self._pool = ProcessPoolExecutor(1, context, initializer=lower, initargs=(NICE,))
            question = partial(predicted, scenario, values, self._live)
            # A Ctrl-C reaches every process of a terminal; this one is ended by close().
            with held_back():
                answer = asyncio.get_running_loop().run_in_executor(self._pool, question)
            try:
                return await answer
            except BrokenProcessPool:
                self._pool = None
                return unknown("The model's process ended.")

    def close(self) -> None:
        """End the process."""
        if self._pool is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = None


def predicted(scenario: Scenario, values: Settings, live: bool) -> dict[str, Any]:
    """Return the prediction for a scenario with settings as its message."""
    from pmwvc_analysis.compare.probes import measured_words
    from pmwvc_analysis.prediction import prediction, text

    try:
        scenario = controls.changed(scenario, values)
    except PmwvcError as error:
        return unknown(str(error))
    try:
        found = prediction.prediction(scenario, live=live)
        lines = text.lines(scenario, live=live)
        if found["mass_felt"] is None and found["stable"] is not False:
            lines.append(measured_words(scenario))
    except PmwvcError as error:
        return unknown(f"No prediction: {error}")
    names = {"stable": "stable", "rendered_stiffness": "k_felt", "mass": "mass_felt"}
    return {**{name: found[key] for name, key in names.items()}, "lines": lines}


def unknown(why: str) -> dict[str, Any]:
    """Return the message where nothing is predicted."""
    return {"stable": None, "rendered_stiffness": None, "mass": None, "lines": [why]}
