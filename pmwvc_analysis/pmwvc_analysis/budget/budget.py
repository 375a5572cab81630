# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session: every joule from the hands to where it went, and what is left.

    hands = devices + safety + channels + server + residual

at every step of the server. Each part is the account of a block (:mod:`pmwvc_core.account`),
stated beside the block's law and summed over the session in :mod:`.blocks`. A part whose sum ever
is below zero has given out energy that it never got: it was *active*.

The residual is what the parts, each computed for itself, do not explain. In a session of which
nothing is missing it is rounding, ``TOLERANCE`` of the energy moved; ticks that were not recorded
(live), and Coulomb friction where the motion turns, show: ``TOLERANCE_NOTED``. Parts that are not
computed for themselves are named with what they hide: :mod:`.parts`. Intervals that are not
on record are left out, and the budget ends where a master or the server was started again:
:mod:`..traces.stretches`.

Equations: docs/theory.md 13.6.
"""

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget import blocks
from pmwvc_analysis.budget.energy import declared_storage_j
from pmwvc_analysis.budget.parts import Remainder, accounted, of_server
from pmwvc_analysis.budget.result import SERVER, Budget
from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.traces.stretches import stretches
from pmwvc_analysis.traces.sums import UserSums, sum_of
from pmwvc_core.controllers import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.transport.packet import LINK


@np.errstate(over="ignore", invalid="ignore")  # a recording may hold any number
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
    waves, live = has_waves(scenario.controller), traces.source == "live"
    time_s, rows = _instants(traces, users)
    into = blocks.into(server, server.users)
    inside, unexplained = blocks.server_parts(server, stages(traces, scenario), into)
    recorded = blocks.into(server, [user.name for user in users])  # the others sent no trace
    hands, parts, frames = {}, {}, {}
    residuals = {SERVER: (unexplained - (into - recorded))[rows]}
    left_over: list[Remainder] = []
    for user in users:
        own, sums = known[user.name], UserSums(user, time_s)
        device, unknown = blocks.device(sums, own.device)
        at_server = [blocks.energy_at(server, user.name, wave)[rows] for wave in ("u_s", "v_s")]
        port, beside = blocks.master(sums, own, waves=waves)
        if scenario.strict:
            port, found = blocks.strict(sums, own, at_server, live=live)
            beside = {}
        elif waves:
            found = blocks.channel(sums, own, at_server, live=live)
            if accounted(user.accounts):
                frames[user.name] = blocks.at_frames(user, own)
                unknown.add("bank" if "bank_low_in" in user.accounts else "filter_and_hold")
        else:
            found = {n: sums.between_blocks(s) for n, s in accounted(user.accounts).items()}
            energies = {"device": np.asarray(port.given), "server": at_server[0] - at_server[1]}
            link = blocks.passed([LINK], energies)[LINK.part]
            if found:
                unknown.add(LINK.part)
            found[LINK.part] = link - sum_of([0.0 * link, *found.values()])
        hands[user.name] = np.asarray(device.taken)
        parts[user.name] = {
            "device_kinetic": np.asarray(device.stored),
            "device_damping": np.asarray(device.dissipated),
            "sample_hold": np.asarray(device.given - port.taken),
            **beside,
            "safety": np.asarray(port.dissipated),
            **found,
        }
        residuals[user.name] = np.asarray(device.residual + port.residual)
        left_over += [Remainder(user.name, part) for part in sorted(unknown)]
    return Budget(
        time_s,
        hands,
        {**parts, SERVER: {part: sums[rows] for part, sums in inside.items()}},
        {name: residuals[name] for name in (*hands, SERVER)},
        frames,
        _tanks(users, scenario),
        _notes(users, known, server, left_over),
        {user.name: declared_storage_j(scenario.controller, known[user.name]) for user in users},
        [*left_over, *(Remainder(SERVER, part) for part in sorted(of_server(scenario)))],
        tuple(hole.unjudged for hole in holes.of_server(server)),
    )


def _instants(traces: SessionTraces, users: list[UserTraces]) -> tuple[Array, NDArray[np.intp]]:
    """Return times and rows of the server's steps that every user's record contains, up to the
    last one that every user's ticks reach.
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
        known &= stays.known(times) & (times < stays.first_s)
    rows = np.flatnonzero(known) if known.any() else np.zeros(1, dtype=np.intp)
    return times[rows], rows


def _tanks(users: list[UserTraces], scenario: Scenario) -> frozenset[str]:
    """Return the owners whose controllers release only what their energy tank holds."""
    found = {user.name for user in users if "position_surplus" in user.accounts}
    server = scenario.server
    if scenario.coupling.black_box and COMPENSATIONS.of(server.compensation).limits:
        found.add(SERVER)
    return frozenset(found)


def _notes(
    users: list[UserTraces],
    known: dict[str, User],
    server: ServerTraces,
    left_over: list[Remainder],
) -> list[str]:
    """Return in words what keeps a budget from closing to rounding."""
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
                "give the true motion"
            )
        if device.friction > 0.0:
            found.append(
                f"{user.name}: the heat of friction is exact except where motion reverses"
            )
    steps = np.diff(server.step)
    if (steps < 0).any():
        again_s = float(server.time_s[int(np.argmax(steps < 0)) + 1])
        found.append(f"server: it was started again at {again_s:.2f} s; the budget ends there")
    if (steps > 1).any():
        found.append(f"server: {int(np.sum(steps[steps > 1] - 1))} steps were not recorded")
    return found
