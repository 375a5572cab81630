# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions within the server's record."""

from collections.abc import Iterator

import numpy as np

from pmwvc_analysis.consistency.numbers import no_numbers, off, power
from pmwvc_analysis.traces.sums import running
from pmwvc_core.controllers.accounts import BRAKES
from pmwvc_core.frame.rows import Presence
from pmwvc_core.law.server.server_port import SLIDE_M_S
from pmwvc_core.numeric import Array, Flags, root
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces
from pmwvc_core.wave.impedance import WavePort


def server(traces: ServerTraces, scenario: Scenario | None, *, waves: bool) -> Iterator[str]:
    """Yield every contradiction in words."""
    yield from no_numbers("server", {"x_o": traces.x_o, "xd_o": traces.xd_o})
    users = {user.name: user for user in scenario.users} if scenario else {}
    exact = scenario is not None and scenario.coupling.balanced
    for index, name in enumerate(traces.users):
        together = _together(traces, index)
        if waves:
            yield from _port(traces, index, users.get(name), exact=exact)
            yield from _sums(traces, index, passes=scenario is None or scenario.strict)
        else:  # what flowed to the avatar against its force and velocity
            work = np.sum(traces.f_s[index] * traces.xd_s[index], axis=-1) * traces.periods_s
            recorded = np.diff(traces.energy_u_s[index]) - np.diff(traces.energy_v_s[index])
            text = f"{name}: the work at the avatar is not its sum"
            yield from off(text, "J", work[1:], recorded, together)
        if scenario is not None and scenario.coupling.moves is not None:  # else it stands
            yield from _motion(traces, index, scenario, together, slides=waves)
        if scenario is not None and scenario.coupling.late and name in users:
            port = WavePort(users[name].server_impedance)
            xd = np.asarray(port.velocity(traces.u_s[index][1:], traces.f_s[index][:-1]))
            text = f"{name}: xd is not decoded from u and the force before at the server"
            rows = together & ~_grown(traces, BRAKES.name)[1:]
            yield from off(text, "m/s", traces.xd_s[index][1:], xd, rows)
    if scenario is not None and scenario.environment.movable and not scenario.coupling.black_box:
        kinetic = 0.5 * scenario.server.object_mass * power(traces.xd_o)
        text = "server: the energy of motion is not m |xd|^2/2 of the object"
        yield from off(text, "J", traces.kinetic, kinetic)
    if "withheld" in traces.accounts:
        yield from _black_box(traces)


def _together(server: ServerTraces, index: int) -> Flags:
    """Tell which steps, from the second on, follow one on record, the user coupled in both."""
    coupled = server.state[index] == Presence.COUPLED
    return np.asarray((np.diff(server.step) == 1) & coupled[1:] & coupled[:-1])


def _motion(
    server: ServerTraces, index: int, scenario: Scenario, together: Flags, *, slides: bool
) -> Iterator[str]:
    """Check that the avatar moves with its velocity, or without contact slides to its device."""
    assert scenario.coupling.moves is not None
    old, new = scenario.coupling.moves(scenario.server)
    moved, xd = np.diff(server.x_s[index], axis=0), server.xd_s[index]
    expected = old * xd[:-1] + new * xd[1:]
    if slides and not scenario.coupling.black_box:
        most_m = np.where(server.contact[index], 0.0, SLIDE_M_S * server.periods_s)[1:]
        inward = -scenario.users[index].side
        slid = np.clip(inward * (moved[:, 0] - expected[:, 0]), 0.0, most_m)
        expected[:, 0] += inward * slid
    text = f"{server.users[index]}: the avatar does not move with its velocity"
    yield from off(text, "m", moved, expected, together)


def _port(server: ServerTraces, index: int, known: User | None, *, exact: bool) -> Iterator[str]:
    """Check the port, but for steps in which a compensation changed the wave that goes back, or an
    avatar was braked; its power only where velocity and force are of the same step.
    """
    changed = _grown(server, "withheld") | _grown(server, BRAKES.name)
    rows = (server.state[index] == Presence.COUPLED) & ~changed
    u, v, f, name = server.u_s[index], server.v_s[index], server.f_s[index], server.users[index]
    if exact:
        work, waves = np.sum(f * server.xd_s[index], axis=-1), (power(u) - power(v)) / 2.0
        text = f"{name}: F xd is not (|u|^2 - |v|^2)/2 at the server"
        yield from off(text, "W", work, waves, rows)
    if known is not None:
        force = root(known.server_impedance / 2.0) * (u - v)
        yield from off(f"{name}: F is not sqrt(b/2) (u - v) at the server", "N", f, force, rows)


def _grown(server: ServerTraces, account: str) -> Flags:
    """Tell in which steps an account changed."""
    sums = server.accounts.get(account, np.zeros(len(server.time_s)))
    return np.asarray(np.diff(sums, prepend=0.0) != 0.0)


def _black_box(server: ServerTraces) -> Iterator[str]:
    """Check the accounts of the port to a black box against waves, forces and motion."""
    own, into = server.accounts, np.zeros(len(server.time_s))
    for u, v, f, xd in zip(server.u_s, server.v_s, server.f_s, server.xd_s, strict=True):
        into += 0.5 * np.nansum(u**2 - v**2, axis=-1) - np.nansum(f * xd, axis=-1)
    recorded = own["late_decoding"] + own["withheld"] + own.get(BRAKES.name, 0.0)
    next_to, accounted = np.diff(server.step, prepend=0) == 1, np.diff(recorded, prepend=0.0)
    text = "server: late decoding and compensation are not as accounted"
    yield from off(text, "J", into * server.periods_s, accounted, next_to)
    taken: Array = own["environment"] + own["contained"]
    came, went = (
        np.sum([running(sums) for sums in waves], axis=0)
        for waves in (server.energy_u_s, server.energy_v_s)
    )
    text = "server: its accounts are not what went in at the ports"
    yield from off(text, "J", came - went, recorded + taken)
    text = "server: stored and heat are not what was taken"
    yield from off(text, "J", server.dissipated, taken - server.potential)


def _sums(server: ServerTraces, index: int, *, passes: bool) -> Iterator[str]:
    """Check the energies of the waves. On the strict channel a port may pass energy on: it takes
    it and gives it, and never takes it back.
    """
    passed = np.zeros(len(server.time_s))
    rows = np.diff(server.step, prepend=server.step[:1] - 1) == 1
    rows &= server.state[index] == Presence.COUPLED
    rows[0] &= server.step[0] == 1
    for wave, sums in (("u_s", server.energy_u_s), ("v_s", server.energy_v_s)):
        own = power(np.nan_to_num(getattr(server, wave)[index])) * server.periods_s / 2.0
        recorded = np.diff(sums[index], prepend=0.0)
        if passes and wave == "u_s":
            passed = np.maximum(recorded - own, 0.0)
        text = f"{server.users[index]}: the energy of {wave} is not its sum"
        yield from off(text, "J", own + passed, recorded, rows)
