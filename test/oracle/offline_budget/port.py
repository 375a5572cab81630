# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts between a device and the server's port: master, filter, links, hold."""

import numpy as np
from oracle.offline_budget.frames import between, booked
from oracle.offline_budget.sums import Clock, Sums, anchored, evenly, half_square, running, sum_of

from pmwvc_analysis.traces.hand_work import complete
from pmwvc_core.numeric import Array, root
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

LIVE_TAKE_S = 0.004  # a live master takes the answer that much into its frame

UNLIMITED_N = 1e-9  # forces closer than this are the same

UNLIMITED_ROOT_W = 1e-9


def port_account(
    clock: Clock, user: UserTraces, known: User, traces: SessionTraces, *, waves: bool
) -> Sums:
    """Return the parts between a device and the server's port, and ``residual``."""
    assert traces.server is not None
    port = master_account(clock, user, known, waves=waves)
    into_channel = port.pop("into_channel")
    if not waves:
        own = evenly(clock, user, booked(user.accounts))
        link = into_channel - into_server(clock, traces.server, user.name)
        return {**port, **own, "link": link - sum_of([*own.values(), 0.0 * link])}
    found = channel_account(clock, user, known, traces.server, live=traces.source == "live")
    if booked(user.accounts):
        own = between(clock, user, known)
        rest = found.pop("filter") + found.pop("hold") - sum_of(list(own.values()))
        found = {**own, "filter_and_hold": rest, **found}
    return {**port, **found}


def into_server(clock: Clock, server: ServerTraces, name: str) -> Array:
    """Return what went into the server at one user's port [J]."""
    place = server.users.index(name)
    sums = running(server.energy_u_s[place]) - running(server.energy_v_s[place])
    return np.asarray(sums[clock.steps], dtype=float)


def master_account(clock: Clock, user: UserTraces, known: User, *, waves: bool) -> Sums:
    """Return ``taken`` (F xd T_c), ``safety``, ``into_channel`` (both ways), ``residual`` of the
    master's port [J], and ``force_velocity_filter`` where there is one.

    In a gap of the record the master's own sums hold, and what was taken there is what they say.
    """
    power = np.sum(user.f_applied * user.xd_m, axis=-1)
    taken = clock.at_ticks(user, power * user.tick_s)
    if not waves:
        said = user.energy["u_m"] - user.energy["v_m"]
        into = clock.of_ticks(user, anchored(user, power * user.tick_s, said))
        taken = taken if complete(user) else into
        return {
            "taken": taken,
            "safety": 0.0 * taken,
            "into_channel": into,
            "residual": taken - into,
        }
    net = half_square(user.u_m) - half_square(user.v_m)
    u_m, v_m = (_kept(clock, user, name) for name in ("u_m", "v_m"))
    if not complete(user):
        taken = taken + (u_m - v_m) - clock.at_ticks(user, net * user.tick_s)
    natural = root(2.0 * known.impedance) * user.xd_m - user.v_m
    limited = (np.abs(user.f_applied - user.f_m) > UNLIMITED_N).any(axis=-1)
    limited |= (np.abs(user.u_m - natural) > UNLIMITED_ROOT_W).any(axis=-1)
    found: Sums = {}
    if known.master.velocity_filter.kind == "equivalent":
        unfiltered = known.impedance * user.xd_m - root(2.0 * known.impedance) * user.v_m
        kept = np.sum((user.f_m - unfiltered) * user.xd_m, axis=-1)
        net = net + kept
        found["force_velocity_filter"] = clock.at_ticks(user, kept * user.tick_s)
    found["safety"] = clock.at_ticks(user, np.where(limited, power - net, 0.0) * user.tick_s)
    left = taken - (u_m - v_m) - sum_of(list(found.values()))
    return {"taken": taken, **found, "into_channel": u_m - v_m, "residual": left}


def _kept(clock: Clock, user: UserTraces, wave: str) -> Array:
    """Return the energy of a wave of the master's ticks."""
    per_tick = half_square(getattr(user, wave)) * user.tick_s
    return clock.of_ticks(user, anchored(user, per_tick, user.energy.get(wave)))


def channel_account(
    clock: Clock, user: UserTraces, known: User, server: ServerTraces, *, live: bool
) -> Sums:
    """Return ``filter``, ``rate_drop``, ``link_up``, ``link_down``, ``hold`` [J].

    Integrate-and-dump filters and drops in one; there the rate drop has nothing of its own. A link
    includes what is under way, and what becomes of packets at a server of another period.
    """
    place = server.users.index(user.name)
    frame_s, take_s = known.master.frame_s, LIVE_TAKE_S if live else 0.0
    u_m, v_m = _kept(clock, user, "u_m"), _kept(clock, user, "v_m")
    u_tx = clock.of_blocks(user, user.energy["u_tx"], frame_s, after_s=0.0)
    v_rx = clock.of_blocks(user, user.energy["v_rx"], frame_s, after_s=take_s)
    u_s, v_s = running(server.energy_u_s[place]), running(server.energy_v_s[place])
    if known.master.filter.kind == "integrate_and_dump":
        filtered = u_tx
    else:
        filtered = clock.at_ticks(user, half_square(user.u_m_lp) * user.tick_s)
    return {
        "filter": u_m - filtered,
        "rate_drop": filtered - u_tx,
        "link_up": u_tx - u_s[clock.steps],
        "link_down": v_s[clock.steps] - v_rx,
        "hold": v_rx - v_m,
    }
