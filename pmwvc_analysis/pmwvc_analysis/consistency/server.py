# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions within the server's record."""

import numpy as np

from pmwvc_analysis.consistency.numbers import no_numbers, off
from pmwvc_analysis.traces.sums import running
from pmwvc_core.controllers.accounts import BRAKES
from pmwvc_core.frame.rows import Presence
from pmwvc_core.law.server.server_port import SLIDE_M_S
from pmwvc_core.numeric import Flags, root
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces
from pmwvc_core.wave.impedance import WavePort


def server(traces: ServerTraces, scenario: Scenario | None, *, waves: bool) -> list[str]:
    """Return every contradiction in words."""
    found = no_numbers("server", {"x_o": traces.x_o, "xd_o": traces.xd_o})
    users = {user.name: user for user in scenario.users} if scenario else {}
    exact = scenario is not None and scenario.coupling.balanced
    for index, name in enumerate(traces.users):
        if waves:
            found += _server_port(traces, index, users.get(name), exact=exact)
            found += _server_sums(traces, index, passes=scenario is None or scenario.strict)
        else:
            found += _flow(traces, index)
        if scenario is not None:
            found += _motion(traces, index, scenario, slides=waves)
            if scenario.coupling.late and name in users:
                found += _late(traces, index, users[name])
    if scenario is not None and scenario.environment.movable:
        found += _object(traces, scenario)
    if "withheld" in traces.accounts:
        found += _black_box(traces)
    return found


def _together(server: ServerTraces, index: int) -> Flags:
    """Tell which steps follow one on record, with the user coupled in both."""
    follows = np.diff(server.step, prepend=server.step[:1] - 2) == 1
    coupled = server.state[index] == Presence.COUPLED
    return np.asarray(follows & coupled & np.concatenate([[False], coupled[:-1]]))


def _motion(server: ServerTraces, index: int, scenario: Scenario, *, slides: bool) -> list[str]:
    """Check that the avatar moves with its velocity, as the coupling has it; without contact it
    may slide to its device as well.
    """
    if scenario.coupling.moves is None:
        return []  # it stands where the device was
    old, new = scenario.coupling.moves(scenario.server)
    x, xd = server.x_s[index], server.xd_s[index]
    rows = _together(server, index)[1:]
    moved = np.diff(x, axis=0)
    expected = old * xd[:-1] + new * xd[1:]
    if slides and not scenario.coupling.black_box:
        most_m = np.where(server.contact[index], 0.0, SLIDE_M_S * server.periods_s)[1:]
        inward = -scenario.users[index].side
        slid = np.clip(inward * (moved[:, 0] - expected[:, 0]), 0.0, most_m)
        expected[:, 0] += inward * slid
    text = f"{server.users[index]}: the avatar does not move with its velocity"
    return off(moved[rows], expected[rows], text, "m")


def _late(server: ServerTraces, index: int, known: User) -> list[str]:
    """Check the velocity that was decoded with the force of the step before."""
    port = WavePort(known.server_impedance)
    expected = np.asarray(port.velocity(server.u_s[index][1:], server.f_s[index][:-1]))
    rows = (_together(server, index) & ~_grown(server, BRAKES.name))[1:]
    text = f"{server.users[index]}: xd is not decoded from u and the force before at the server"
    return off(server.xd_s[index][1:][rows], expected[rows], text, "m/s")


def _object(server: ServerTraces, scenario: Scenario) -> list[str]:
    """Check the object's energy of motion against its velocity."""
    if scenario.coupling.black_box:
        return []  # it is what the environment shows
    kinetic = 0.5 * scenario.server.object_mass * np.sum(server.xd_o**2, axis=-1)
    text = "server: the energy of motion is not m |xd|^2/2 of the object"
    return off(server.kinetic, kinetic, text, "J")


def _flow(server: ServerTraces, index: int) -> list[str]:
    """Check what flowed to an avatar without waves against its force and velocity."""
    own = np.sum(server.f_s[index] * server.xd_s[index], axis=-1) * server.periods_s
    recorded = np.diff(server.energy_u_s[index]) - np.diff(server.energy_v_s[index])
    rows = _together(server, index)[1:]
    text = f"{server.users[index]}: the work at the avatar is not its sum"
    return off(own[1:][rows], recorded[rows], text, "J")


def _server_port(
    server: ServerTraces, index: int, known: User | None, *, exact: bool
) -> list[str]:
    """Check the port, but for steps in which a compensation changed the wave that goes back, or an
    avatar was braked; its power only where velocity and force are of the same step.
    """
    changed = _grown(server, "withheld") | _grown(server, BRAKES.name)
    rows = (server.state[index] == Presence.COUPLED) & ~changed
    u_s, v_s = server.u_s[index][rows], server.v_s[index][rows]
    f_s, xd_s = server.f_s[index][rows], server.xd_s[index][rows]
    name, found = server.users[index], list[str]()
    waves = (np.sum(u_s**2, axis=-1) - np.sum(v_s**2, axis=-1)) / 2.0
    if exact:
        text = f"{name}: F xd is not (|u|^2 - |v|^2)/2 at the server"
        found += off(np.sum(f_s * xd_s, axis=-1), waves, text, "W")
    if known is not None:
        force = root(known.server_impedance / 2.0) * (u_s - v_s)
        found += off(f_s, force, f"{name}: F is not sqrt(b/2) (u - v) at the server", "N")
    return found


def _grown(server: ServerTraces, account: str) -> Flags:
    """Tell in which steps an account changed."""
    sums = server.accounts.get(account, np.zeros(len(server.time_s)))
    return np.asarray(np.diff(sums, prepend=0.0) != 0.0)


def _black_box(server: ServerTraces) -> list[str]:
    """Check the accounts of the port to a black box against waves, forces and motion."""
    power = np.zeros(len(server.time_s))
    for u, v, f, xd in zip(server.u_s, server.v_s, server.f_s, server.xd_s, strict=True):
        power += 0.5 * np.nansum(u**2 - v**2, axis=-1) - np.nansum(f * xd, axis=-1)
    recorded = server.accounts["late_decoding"] + server.accounts["withheld"]
    recorded = recorded + server.accounts.get(BRAKES.name, 0.0)
    next_to = np.diff(server.step, prepend=0) == 1
    accounted = np.diff(recorded, prepend=0.0)
    text = "server: late decoding and compensation are not as accounted"
    found = off((power * server.periods_s)[next_to], accounted[next_to], text, "J")
    taken = server.accounts["environment"] + server.accounts["contained"]
    into = np.sum([running(sums) for sums in server.energy_u_s], axis=0)
    into = into - np.sum([running(sums) for sums in server.energy_v_s], axis=0)
    text = "server: its accounts are not what went in at the ports"
    found += off(into, recorded + taken, text, "J")
    text = "server: stored and heat are not what was taken"
    return found + off(server.dissipated, taken - server.potential, text, "J")


def _server_sums(server: ServerTraces, index: int, *, passes: bool) -> list[str]:
    """Check the energies of the waves. On the strict channel a port may pass energy on: it takes
    it and gives it, and never takes it back.
    """
    found, name = list[str](), server.users[index]
    passed = np.zeros(len(server.time_s))
    follows = np.diff(server.step, prepend=server.step[:1] - 1) == 1
    for wave, sums in (("u_s", server.energy_u_s), ("v_s", server.energy_v_s)):
        values = np.nan_to_num(getattr(server, wave)[index])
        own = np.sum(values**2, axis=-1) * server.periods_s / 2.0
        recorded = np.diff(sums[index], prepend=0.0)
        if passes and wave == "u_s":
            passed = np.maximum(recorded - own, 0.0)
        own = own + passed
        rows = follows & (server.state[index] == Presence.COUPLED)
        rows[0] = rows[0] and server.step[0] == 1
        found += off(
            own[rows], recorded[rows], f"{name}: the energy of {wave} is not its sum", "J"
        )
    return found
