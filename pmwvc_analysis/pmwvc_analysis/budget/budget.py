# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session: every joule from the hands to where it went, and what is left.

    hands = devices + safety + channels + server + residual

at every step of the server. A part whose sum ever is below zero has given out energy that it never
got: it was *active*. Parts and what they rest on: :mod:`.budget_device`,
:mod:`.budget_channel`, :mod:`.budget_server`.

The residual is what the parts, each computed for itself, do not explain. In a session of which
nothing is missing it is rounding, ``TOLERANCE`` of the energy moved; ticks that were not recorded
(live), and Coulomb friction where the motion turns, show: ``TOLERANCE_NOTED``. Parts that are not
computed for themselves are named with what they hide: :mod:`.remainders`. Intervals that are not
on record are left out, and the budget ends where a master or the server was started again:
:mod:`.stretches`.

Equations: docs/theory.md 13.6.
"""

import numpy as np

from pmwvc_analysis.budget.budget_around import at_frames, between, evenly
from pmwvc_analysis.budget.budget_channel import channel_account, master_account
from pmwvc_analysis.budget.budget_clock import Clock, Sums, sum_of
from pmwvc_analysis.budget.budget_device import device_account
from pmwvc_analysis.budget.budget_result import SERVER, Budget
from pmwvc_analysis.budget.budget_server import server_account
from pmwvc_analysis.budget.budget_words import booked
from pmwvc_analysis.budget.energy import declared_storage_j
from pmwvc_analysis.budget.remainders import Remainder, of_server
from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces.stretches import stretches
from pmwvc_analysis.traces.sums import running
from pmwvc_core.controllers import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


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
    clock = _clock(traces, users)
    inside = server_account(clock, server, scenario)
    shared = inside.pop("into_server")
    waves = has_waves(scenario.controller)
    hands, parts, residuals, frames = {}, {}, {}, {}
    left_over: list[Remainder] = []
    for user in users:
        own = known[user.name]
        device, unknown = device_account(clock, user, own.device)
        hands[user.name] = device.pop("hand")
        residuals[user.name] = device.pop("residual")
        port = _port(clock, user, own, traces, waves=waves)
        residuals[user.name] = residuals[user.name] + port.pop("residual")
        device["sample_hold"] = device.pop("rendered") - port.pop("taken")
        parts[user.name] = {**device, **port}
        if waves and booked(user.accounts):
            frames[user.name] = at_frames(user, own)
            unknown.add("bank" if "bank_low_in" in user.accounts else "filter_and_hold")
        if "tdpa_dissipated" in user.accounts:
            unknown.add("link")
        left_over += [Remainder(user.name, part) for part in sorted(unknown)]
        shared = shared - _into(clock, server, user.name)
    residuals[SERVER] = inside.pop("residual") - shared  # of users whose own trace is not there
    return Budget(
        clock.time_s,
        hands,
        {**parts, SERVER: inside},
        residuals,
        frames,
        _paid(users, scenario),
        _notes(traces, users, scenario, left_over),
        {user.name: declared_storage_j(scenario.controller, known[user.name]) for user in users},
        [*left_over, *(Remainder(SERVER, part) for part in sorted(of_server(scenario)))],
        tuple(hole.unjudged for hole in holes.of_server(server)),
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
    if scenario.coupling.black_box and COMPENSATIONS.of(server.compensation).limits:
        found.add(SERVER)
    return frozenset(found)


def _into(clock: Clock, server: ServerTraces, name: str) -> Array:
    """Return what went into the server at one user's port [J]."""
    place = server.users.index(name)
    sums = running(server.energy_u_s[place]) - running(server.energy_v_s[place])
    return np.asarray(sums[clock.steps], dtype=float)


def _clock(traces: SessionTraces, users: list[UserTraces]) -> Clock:
    """Return the times of the server's steps of which every user's record tells, up to the last
    one that every user's ticks reach.
    """
    assert traces.server is not None
    times = traces.server.time_s
    lateness = traces.metadata.get("server_lateness_s")
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    end = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    known = times <= end + 1e-9
    for user in users:
        stays = stretches(user, traces.server, traces)
        known &= stays.known(times) & (times <= stays.lives[0].end_s)
    rows = np.flatnonzero(known) if known.any() else np.zeros(1, dtype=np.intp)
    return Clock(times[rows], rows)


def _notes(
    traces: SessionTraces,
    users: list[UserTraces],
    scenario: Scenario,
    left_over: list[Remainder],
) -> list[str]:
    """Return in words what keeps a budget from closing to rounding."""
    known = {user.name: user for user in scenario.users}
    found = []
    for user in users:
        device = known[user.name].device
        if not np.isfinite(user.f_h).all():
            found.append(
                f"{user.name}: the hand's force was not measured; its work is inferred from the "
                "motion of the device"
            )
        steps = np.diff(user.tick)
        missing = int(np.sum(steps[steps > 1] - 1))
        if (steps < 0).any():
            again_s = float(user.time_s[int(np.argmax(steps < 0)) + 1])
            found.append(
                f"{user.name}: its master was started again at {again_s:.2f} s; the budget ends "
                "there"
            )
        if missing:
            found.append(f"{user.name}: {count(missing, 'tick')} not recorded")
        if Remainder(user.name, "device_damping") in left_over:
            found.append(
                f"{user.name}: position or velocity is measured, and its device's model does not "
                "tell the true motion"
            )
        if device.friction > 0.0:
            found.append(
                f"{user.name}: the heat of friction is exact except where motion reverses"
            )
    assert traces.server is not None
    steps = np.diff(traces.server.step)
    if (steps < 0).any():
        again_s = float(traces.server.time_s[int(np.argmax(steps < 0)) + 1])
        found.append(f"server: it was started again at {again_s:.2f} s; the budget ends there")
    if (steps > 1).any():
        found.append(f"server: {int(np.sum(steps[steps > 1] - 1))} steps were not recorded")
    return found
