# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where energy goes between the ports: safety, filter, rate drop, links, hold [J].

======================  ==========================================================================
safety                  F xd T_c less (|u_m|^2 - |v_m|^2) T_c/2, in ticks that were limited
filter, rate drop,      differences of the energies of u_m, u_m after the filter, u_tx, u_s and of
link, hold              v_s, v_rx, v_m
force_velocity_filter   (F_m - b xd + sqrt(2b) v_m) xd T_c, of the equivalent velocity filter: at
                        the device, beside the waves
======================  ==========================================================================
"""

import numpy as np

from pmwvc_analysis.budget.budget_clock import Clock, Sums, sum_of
from pmwvc_analysis.traces.sums import anchored, half_square, running
from pmwvc_analysis.traces.true_motion import complete
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.numeric import Array, root
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import ServerTraces, UserTraces
from pmwvc_core.wave.transform import WavePort

UNLIMITED_N = 1e-9  # forces closer than this are the same
UNLIMITED_ROOT_W = 1e-9


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
        unfiltered = WavePort(known.impedance).force(user.xd_m, user.v_m)
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
    frame_s, take_s = known.master.frame_s, (LIVE if live else AT_ONCE).answer_s
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
