# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions between the numbers of a recording: a list of invariants.

At a port with impedance b, F = sqrt(b/2) (u - v) and xd = (u + v)/sqrt(2b) hold for every sample;
so does F xd = (|u|^2 - |v|^2)/2. The running sums that master and server keep have to be the sums
of what they recorded. Where parameters changed in flight, the record is looked at up to the first
change; where an invariant holds in some rows only, it is looked at there. Together with the energy
budget they find every trace that was falsified but those that test/unit/test_falsified.py lists.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.traces.block_sums import BlockSums, complete, measured
from pmwvc_analysis.traces.stages import stages, until
from pmwvc_core.controllers.accounts import BRAKES
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.frame import SIGNALS, Presence
from pmwvc_core.law.vectors import LARGEST
from pmwvc_core.law.wave.wave import rooted, wave_force, wave_u
from pmwvc_core.made.waves import through
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

RELATIVE, SMALLEST = 1e-6, 1e-9  # differences up to these are rounding
# Accounts of what answers the outgoing wave within the tick, or takes another velocity: what a
# port makes of it is not on record.
ANSWERS = {"velocity_filter", "force_velocity_filter", "local_stored", "bank_low_in"}


@np.errstate(over="ignore", invalid="ignore")  # a recording may hold any number: those are named
def inconsistencies(traces: SessionTraces, scenario: Scenario | None) -> list[str]:
    """Return every contradiction in words."""
    found: list[str] = []
    for user in traces.users:
        found += _no_numbers(user.name, {n: getattr(user, n) for n in SIGNALS if n != "f_h"})
    if traces.server is not None:
        found += _no_numbers("server", {n: getattr(traces.server, n) for n in ("x_o", "xd_o")})
    changes = stages(traces, scenario)[1:] if scenario else []
    for change in changes[:1]:  # packets of before are on their way
        slowest_s = max(user.master.frame_s for user in change.scenario.users)
        traces = until(traces, change.start_s - 2.0 * slowest_s)
    users = {user.name: user for user in scenario.users} if scenario else {}
    for user in traces.users:
        found += _master(user, users.get(user.name), scenario)
    return found + (list(_server(traces.server, scenario)) if traces.server else [])


def _no_numbers(owner: str, signals: Mapping[str, Array]) -> Iterator[str]:
    """Yield in words which signals have values that are not finite, or that nothing real has."""
    for name, values in signals.items():
        finite = np.isfinite(values)
        if count := (~finite).sum():
            yield f"{owner}: {name} has {count} values that are not finite"
        if count := (finite & (np.abs(values) > LARGEST)).sum():
            yield f"{owner}: {name} has {count} values beyond {LARGEST:g}"


def _off(text: str, unit: str, left: Array, right: Array, rows: Any = ...) -> Iterator[str]:
    """Yield in words by how much two sides of an invariant are off, beyond rounding."""
    left, right = left[rows], right[rows]
    gap = float(np.abs(left - right).max(initial=0.0))
    if gap > SMALLEST + RELATIVE * float(np.abs([left, right]).max(initial=0.0)):
        yield f"{text}, {gap:.3g} {unit} off"


def _power(waves: Array) -> Array:
    return np.asarray(np.sum(waves**2, axis=-1))


def _master(user: UserTraces, known: User | None, scenario: Scenario | None) -> Iterator[str]:
    """Yield the contradictions in the record of a master."""
    name = user.name
    if known is not None and complete(user) and not measured(known.device):
        yield from _work(user)
    if scenario is not None and not has_waves(scenario.controller):
        return
    for wave in ("u_m", "v_m"):
        sums = _blocks(user, _power(getattr(user, wave)) * user.tick_s / 2.0, user.energy[wave])
        yield from _off(f"{name}: the energy of {wave} is not its sum", "J", *sums)
    if known is None or ANSWERS & user.accounts.keys() or known.master.rises > 1.0:
        return
    b, strict = known.impedance, scenario is not None and scenario.strict
    if not strict:
        force = through(wave_force, b, user.xd_m, user.v_m)
        yield from _off(f"{name}: F is not b xd - sqrt(2b) v_m", "N", user.f_m, force)
    if complete(user) and not (strict and measured(known.device)):  # nor is what counts make of it
        free = np.cumsum((np.abs(user.f_applied - user.f_m) > SMALLEST).any(axis=-1)) == 0
        u_m = through(wave_u, b, user.xd_m, user.v_m)
        yield from _off(f"{name}: u_m is not sqrt(2b) xd - v_m", "sqrt(W)", user.u_m, u_m, free)


def _blocks(user: UserTraces, per_tick: Array, recorded: Array) -> tuple[Array, Array]:
    """Return a sum over whole blocks from the ticks, and as the master kept it."""
    lasted = np.diff(user.block_time_s)
    whole = np.append(user.tick[0] == 0, lasted < 1.5 * np.median(lasted))
    sums = BlockSums(user).of_ticks(per_tick), recorded
    own, kept = (np.diff(each, prepend=0.0)[whole] for each in sums)
    return own, kept


def _work(user: UserTraces) -> Iterator[str]:
    """Check the work of both forces against forces and motion, tick by tick."""
    moved = np.diff(user.x_m, axis=0, append=user.x_m[-1:])
    for name, force in (("device", user.f_applied), ("hand", user.f_h)):
        if np.isfinite(force).all():
            own, recorded = _blocks(user, np.sum(force * moved, axis=-1), user.energy[name])
            text = f"{user.name}: the work of the {name} is not its sum"
            yield from _off(text, "J", own[:-1], recorded[:-1])


def _server(server: ServerTraces, scenario: Scenario | None) -> Iterator[str]:
    """Yield the contradictions in the record of the server."""
    users = {user.name: user for user in scenario.users} if scenario else {}
    follows = np.diff(server.step, prepend=server.step[:1] - 1) == 1
    for index, name in enumerate(server.users):
        rows = follows & (server.state[index] == Presence.COUPLED)
        rows[0] &= server.step[0] == 1
        if scenario is not None and not has_waves(scenario.controller):
            work = np.sum(server.f_s[index] * server.xd_s[index], axis=-1) * server.periods_s
            came = np.diff(server.energy_u_s[index] - server.energy_v_s[index], prepend=0.0)
            text = f"{name}: the work at the avatar is not its sum"
            yield from _off(text, "J", work, came, rows & np.append(False, rows[:-1]))
            continue
        yield from _port(server, index, users.get(name), scenario)
        passed = np.zeros(len(server.time_s))  # it takes and gives it, never takes it back
        for wave, sums in (("u_s", server.energy_u_s), ("v_s", server.energy_v_s)):
            grown, power = np.diff(sums[index], prepend=0.0), _power(getattr(server, wave)[index])
            own = np.nan_to_num(power) * server.periods_s / 2.0
            if wave == "u_s" and (scenario is None or scenario.strict):
                passed = np.maximum(grown - own, 0.0)
            text = f"{name}: the energy of {wave} is not its sum"
            yield from _off(text, "J", own + passed, grown, rows)
    if scenario is not None and scenario.environment.movable and not scenario.coupling.black_box:
        kinetic = 0.5 * scenario.server.object_mass * _power(server.xd_o)
        text = "server: the energy of motion is not m |xd|^2/2 of the object"
        yield from _off(text, "J", server.kinetic, kinetic)
    if "withheld" in server.accounts:
        heat = server.accounts["environment"] + server.accounts["contained"] - server.potential
        text = "server: stored and heat are not what was taken"
        yield from _off(text, "J", server.dissipated, heat)


def _port(
    server: ServerTraces, index: int, known: User | None, scenario: Scenario | None
) -> Iterator[str]:
    """Check the port, but for steps in which a compensation changed the wave that goes back, or an
    avatar was braked; its power only where velocity and force are of the same step, its force
    only where the impedance does not follow contact.
    """
    rows = np.asarray(server.state[index] == Presence.COUPLED)
    for account in {"withheld", BRAKES.name} & server.accounts.keys():
        rows &= np.diff(server.accounts[account], prepend=0.0) == 0.0
    u, v, f, name = server.u_s[index], server.v_s[index], server.f_s[index], server.users[index]
    if scenario is not None and scenario.coupling.balanced:
        work, waves = np.sum(f * server.xd_s[index], axis=-1), (_power(u) - _power(v)) / 2.0
        text = f"{name}: F xd is not (|u|^2 - |v|^2)/2 at the server"
        yield from _off(text, "W", work, waves, rows)
    if known is not None and known.master.rises == 1.0:
        force = 0.5 * through(rooted, known.server_impedance, u - v)
        yield from _off(f"{name}: F is not sqrt(b/2) (u - v) at the server", "N", f, force, rows)
