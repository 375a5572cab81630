# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session: every joule from the hands to where it went, and what is left.

    hands = devices + safety + channels + server + residual

at every step of the server. A part whose sum ever is below zero has given out energy that it never
got: it was *active*. Parts and what they rest on: :mod:`.budget_device`,
:mod:`.budget_channel`, :mod:`.budget_server`.

The residual is what the parts, each computed for itself, do not explain. In a session of which
nothing is missing it is rounding, ``TOLERANCE`` of the energy moved; ticks that were not recorded
(live), and Coulomb friction where the motion turns, show: ``TOLERANCE_NOTED``. Where position or
velocity are measured rather than exact, what the sensors make up cannot be told from the sample
and hold, which is then what the other parts of the device leave over.
"""

import numpy as np

from pmwvc_analysis.judge.budget_around import at_frames, between, evenly
from pmwvc_analysis.judge.budget_channel import channel_account, master_account
from pmwvc_analysis.judge.budget_clock import Clock, Sums, sum_of
from pmwvc_analysis.judge.budget_device import device_account
from pmwvc_analysis.judge.budget_result import SERVER, Budget
from pmwvc_analysis.judge.budget_server import server_account
from pmwvc_analysis.judge.budget_words import booked
from pmwvc_analysis.judge.energy import running
from pmwvc_analysis.judge.true_motion import measured
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.wave.content import has_waves


def budget(traces: SessionTraces, scenario: Scenario | None) -> Budget | None:
    """Return the budget of a session; None without scenario, server or the master's own sums, and
    where motion is not finite.
    """
    server = traces.server
    if server is None or scenario is None or not len(server.time_s):
        return None
    known = {user.name: user for user in scenario.users}
    users = [u for u in traces.users if u.name in known and u.name in server.users]
    if not users or any(len(u.time_s) < 2 or "u_tx" not in u.energy for u in users):
        return None
    if not all(np.isfinite(u.x_m).all() and np.isfinite(u.xd_m).all() for u in users):
        return None
    clock = Clock(_times(traces, users))
    inside = server_account(clock, server, scenario)
    shared = inside.pop("into_server")
    waves = has_waves(scenario.controller)
    hands, parts, residuals, frames, remainders = {}, {}, {}, {}, {}
    for user in users:
        own = known[user.name]
        device, remainders[user.name] = device_account(clock, user, own.device)
        hands[user.name] = device.pop("hand")
        residuals[user.name] = device.pop("residual")
        port = _port(clock, user, own, traces, waves=waves)
        residuals[user.name] = residuals[user.name] + port.pop("residual")
        device["sample_hold"] = device.pop("rendered") - port.pop("taken")
        parts[user.name] = {**device, **port}
        if waves and booked(user.accounts):
            frames[user.name] = at_frames(user, own)
        shared = shared - _into(clock, server, user.name)
    residuals[SERVER] = inside.pop("residual") - shared  # of users whose own trace is not there
    return Budget(
        clock.time_s,
        hands,
        {**parts, SERVER: inside},
        residuals,
        frames,
        _paid(users, scenario),
        _notes(traces, users, scenario),
    )


def _port(
    clock: Clock, user: UserTraces, known: User, traces: SessionTraces, *, waves: bool
) -> Sums:
    """Return the parts between a device and the server's port, and ``residual``."""
    assert traces.server is not None
    port = master_account(clock, user, known, waves=waves)
    into_channel = port.pop("into_channel")
    if not waves:
        own = evenly(clock, user, booked(user.accounts))
        link = into_channel - _into(clock, traces.server, user.name)
        return {**port, **own, "link": link - sum_of([*own.values(), 0.0 * link])}
    found = channel_account(clock, user, known, traces.server, live=traces.source == "live")
    if booked(user.accounts):
        own = between(clock, user, known)
        rest = found.pop("filter") + found.pop("hold") - sum_of(list(own.values()))
        found = {**own, "filter_and_hold": rest, **found}
    return {**port, **found}


def _paid(users: list[UserTraces], scenario: Scenario) -> frozenset[str]:
    """Return the owners whose controllers spend only what they have got."""
    found = {user.name for user in users if "position_surplus" in user.accounts}
    server = scenario.server
    if server.coupling == "unknown" and server.compensation in ("corrected", "ledger"):
        found.add(SERVER)
    return frozenset(found)


def _into(clock: Clock, server: ServerTraces, name: str) -> Array:
    """Return what went into the server at one user's port [J]."""
    place = server.users.index(name)
    sums = running(server.energy_u_s[place]) - running(server.energy_v_s[place])
    return sums[: len(clock.time_s)]


def _times(traces: SessionTraces, users: list[UserTraces]) -> Array:
    """Return the times of the server's steps, up to the last one every user's ticks reach."""
    assert traces.server is not None
    times = traces.server.time_s
    lateness = traces.metadata.get("server_lateness_s")
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    end = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    reached: Array = times[times <= end + 1e-9]
    return reached if len(reached) else times[:1]


def _notes(traces: SessionTraces, users: list[UserTraces], scenario: Scenario) -> list[str]:
    """Return in words what keeps a budget from closing to rounding."""
    known = {user.name: user for user in scenario.users}
    found = []
    for user in users:
        device = known[user.name].device
        if not np.isfinite(user.f_h).all():
            found.append(
                f"{user.name}: the hand's force was not measured; it is taken to have given what "
                "the device shows"
            )
        missing = int(np.sum(np.diff(user.tick) - 1))
        if missing:
            found.append(f"{user.name}: {missing} ticks were not recorded")
        if measured(device):
            found.append(
                f"{user.name}: position or velocity is measured, not exact; what the sensors make "
                "up counts as sample and hold"
            )
        if device.friction > 0.0:
            found.append(f"{user.name}: the heat of friction is exact but where motion turns")
    assert traces.server is not None
    steps = int(np.sum(np.diff(traces.server.step) - 1))
    if steps:
        found.append(f"server: {steps} steps were not recorded")
    return found
