# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the numbers of a recording fit each other.

At a port with impedance b, F = sqrt(b/2) (u - v) and xd = (u + v)/sqrt(2b) hold for every sample;
so does F xd = (|u|^2 - |v|^2)/2. The running sums that master and server keep have to be the sums
of the waves they recorded.
"""

import numpy as np

from pmwvc_core.numeric import Array, root
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.wave.content import has_waves

RELATIVE = 1e-6
SMALLEST = 1e-9
COUPLED = 2
EXACT_COUPLINGS = ("implicit", "unwrapped")


def inconsistencies(traces: SessionTraces, scenario: Scenario | None) -> list[str]:
    """Return every contradiction in words."""
    found = []
    users = {user.name: user for user in scenario.users} if scenario else {}
    waves = scenario is None or has_waves(scenario.controller)
    exact = scenario is not None and scenario.server.coupling in EXACT_COUPLINGS
    for user in traces.users:
        found += _not_finite(user.name, {n: getattr(user, n) for n in MASTER_SIGNALS})
        if waves:
            found += _master_port(user, users.get(user.name))
            found += _master_sums(user)
    if traces.server is not None:
        found += _not_finite("server", {"x_o": traces.server.x_o, "xd_o": traces.server.xd_o})
        for place, name in enumerate(traces.server.users):
            if waves:
                found += _server_port(traces.server, place, users.get(name), exact=exact)
                found += _server_sums(traces.server, place)
        if "withheld" in traces.server.accounts:
            found += _booked(traces.server)
    return found


MASTER_SIGNALS = ("x_m", "xd_m", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")


def differs(left: Array, right: Array) -> float | None:
    """Return the largest difference where it is more than rounding can explain, else None."""
    if not left.size:
        return None
    gap = float(np.abs(left - right).max())
    size = float(max(np.abs(left).max(), np.abs(right).max()))
    return gap if gap > SMALLEST + RELATIVE * size else None


def _not_finite(owner: str, signals: dict[str, Array]) -> list[str]:
    return [
        f"{owner}: {name} has {int((~np.isfinite(values)).sum())} values that are not finite"
        for name, values in signals.items()
        if not np.isfinite(values).all()
    ]


def _master_port(user: UserTraces, known: User | None) -> list[str]:
    """Check the port where the safety layer let the force through unchanged.

    With a force that was limited, the outgoing wave is scaled and the identity does not hold; nor
    does it where the velocity in the force is filtered for itself.
    """
    if "force_velocity_filter" in user.accounts:
        return []
    rows = (np.abs(user.f_applied - user.f_m) <= SMALLEST).all(axis=-1)
    power = np.sum(user.f_m * user.xd_m, axis=-1)[rows]
    waves = (np.sum(user.u_m**2, axis=-1) - np.sum(user.v_m**2, axis=-1))[rows] / 2.0
    found = []
    if (gap := differs(power, waves)) is not None:
        found.append(f"{user.name}: F xd is not (|u|^2 - |v|^2)/2 at the master, {gap:.3g} W off")
    if known is not None:
        force = root(known.impedance / 2.0) * (user.u_m - user.v_m)[rows]
        if (gap := differs(user.f_m[rows], force)) is not None:
            found.append(f"{user.name}: F is not sqrt(b/2) (u - v) at the master, {gap:.3g} N off")
    return found


def _master_sums(user: UserTraces) -> list[str]:
    """Check the sums of each block against the waves of its ticks, where no tick is missing."""
    ends = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
    found = []
    for name, wave in (("u_m", user.u_m), ("v_m", user.v_m)):
        sums = np.concatenate([[0.0], np.cumsum(np.sum(wave**2, axis=-1))]) * user.tick_s / 2.0
        own = np.diff(sums[np.concatenate([[0], ends])])
        said = np.diff(user.energy[name], prepend=0.0)
        whole = np.ones(len(own), dtype=bool)
        whole[1:] = np.diff(user.block_time_s) < 1.5 * np.median(np.diff(user.block_time_s))
        whole[0] = user.tick[0] == 0
        if (gap := differs(own[whole], said[whole])) is not None:
            found.append(f"{user.name}: the energy of {name} is not its sum, {gap:.3g} J off")
    return found


def _server_port(
    server: ServerTraces, place: int, known: User | None, *, exact: bool
) -> list[str]:
    """Check the port, but for steps in which a compensation changed the wave that goes back; its
    power only where velocity and force are of the same step.
    """
    withheld = server.accounts.get("withheld", np.zeros(len(server.time_s)))
    changed = np.diff(withheld, prepend=0.0) != 0.0
    rows = (server.state[place] == COUPLED) & ~changed
    u_s, v_s = server.u_s[place][rows], server.v_s[place][rows]
    f_s, xd_s = server.f_s[place][rows], server.xd_s[place][rows]
    name, found = server.users[place], []
    waves = (np.sum(u_s**2, axis=-1) - np.sum(v_s**2, axis=-1)) / 2.0
    if exact and (gap := differs(np.sum(f_s * xd_s, axis=-1), waves)) is not None:
        found.append(f"{name}: F xd is not (|u|^2 - |v|^2)/2 at the server, {gap:.3g} W off")
    if known is not None:
        force = root(known.server_impedance / 2.0) * (u_s - v_s)
        if (gap := differs(f_s, force)) is not None:
            found.append(f"{name}: F is not sqrt(b/2) (u - v) at the server, {gap:.3g} N off")
    return found


def _booked(server: ServerTraces) -> list[str]:
    """Check the accounts of a port to an unknown environment against waves, forces and motion."""
    power = np.zeros(len(server.time_s))
    for u, v, f, xd in zip(server.u_s, server.v_s, server.f_s, server.xd_s, strict=True):
        power += 0.5 * np.nansum(u**2 - v**2, axis=-1) - np.nansum(f * xd, axis=-1)
    said = server.accounts["late_decoding"] + server.accounts["withheld"]
    next_to = np.diff(server.step, prepend=0) == 1
    gap = differs((power * server.period_s)[next_to], np.diff(said, prepend=0.0)[next_to])
    if gap is None:
        return []
    return [f"server: late decoding and compensation are not as booked, {gap:.3g} J off"]


def _server_sums(server: ServerTraces, place: int) -> list[str]:
    found, name = [], server.users[place]
    follows = np.diff(server.step, prepend=server.step[:1] - 1) == 1
    for wave, sums in (("u_s", server.energy_u_s), ("v_s", server.energy_v_s)):
        values = np.nan_to_num(getattr(server, wave)[place])
        own = np.sum(values**2, axis=-1) * server.period_s / 2.0
        said = np.diff(sums[place], prepend=0.0)
        rows = follows & (server.state[place] == COUPLED)
        rows[0] = rows[0] and server.step[0] == 1
        if (gap := differs(own[rows], said[rows])) is not None:
            found.append(f"{name}: the energy of {wave} is not its sum, {gap:.3g} J off")
    return found
