# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions between the numbers of a recording.

At a port with impedance b, F = sqrt(b/2) (u - v) and xd = (u + v)/sqrt(2b) hold for every sample;
so does F xd = (|u|^2 - |v|^2)/2. Where b follows contact, the forces on record tell it. The
running sums that master and server keep have to be the sums of what they recorded, positions have
to follow velocities, and what was sent has to be in the packets. Of a master: :mod:`.master`; of
server and packets here, packets where every one of a sender's life is on record. Where parameters
changed in flight, a server is looked at stage by stage, a master up to its first change. Together
with the energy budget they find every trace that was falsified but those that
test/unit/test_falsified.py lists.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pmwvc_analysis.consistency.master import master, missing, off, power
from pmwvc_analysis.traces.arrivals import with_deadband
from pmwvc_analysis.traces.stages import Stage, stages, user_until, with_rows
from pmwvc_core.controllers.accounts import BRAKES
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.frame import SIGNALS, Presence
from pmwvc_core.law.server.server_port import SLIDE_M_S
from pmwvc_core.law.wave.following import FREE, followed
from pmwvc_core.numeric import LARGEST, Array, Flags, root
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces, UserTraces

NEAR_PERIODS = 2.5  # of the server: the step that takes a change over is known to one or two


@np.errstate(over="ignore", invalid="ignore")  # a recording may hold any number: those are named
def inconsistencies(traces: SessionTraces, scenario: Scenario | None) -> list[str]:
    """Return every contradiction in words."""
    found: list[str] = []
    users = {user.name: user for user in scenario.users} if scenario else {}
    waves = scenario is None or has_waves(scenario.controller)
    strict = scenario is not None and scenario.strict
    steady = stages(traces, scenario) if scenario else []
    for user in traces.users:
        found += no_numbers(user.name, {n: getattr(user, n) for n in SIGNALS if n != "f_h"})
        known = users.get(user.name)
        for same in _before_change(user, steady):
            found += master(same, known, waves=waves, strict=strict, simulated=traces.simulated)
    if (own := traces.server) is not None:
        for known_then, part in _parts(own, steady) if len(steady) > 1 else [(scenario, own)]:
            found += server(part, known_then, waves=waves)
    found = list(dict.fromkeys(found))
    return found + list(_packets(traces, scenario)) if scenario and waves else found


def _before_change(user: UserTraces, found: Sequence[Stage]) -> Iterator[UserTraces]:
    """Yield the trace of a master up to the first change of its parameters."""
    first_s = np.inf
    for before, after in itertools.pairwise(found):
        for one, two in zip(before.scenario.users, after.scenario.users, strict=True):
            changed = one.master is not two.master or one.safety is not two.safety
            if one.name == user.name and changed:
                first_s = min(first_s, after.start_s - 2.0 * one.master.frame_s)
    if not np.isfinite(first_s):
        yield user
    elif first_s > user.block_time_s[0]:
        yield user_until(user, first_s)


def _parts(
    server: ServerTraces, found: Sequence[Stage]
) -> Iterator[tuple[Scenario, ServerTraces]]:
    """Yield the steps of each stage, without those next to a change."""
    ends = [stage.start_s for stage in found[1:]] + [np.inf]
    near_s = NEAR_PERIODS * server.period_s
    for stage, end_s in zip(found, ends, strict=True):
        rows = (server.time_s > stage.start_s + near_s) & (server.time_s < end_s - near_s)
        if rows.any():
            yield stage.scenario, with_rows(server, rows)


def _packets(traces: SessionTraces, scenario: Scenario) -> Iterator[str]:
    """Yield in words where sums of energy are not those of the packets."""
    frames = {user.name: user.master.frame_s for user in scenario.users}
    held_back = with_deadband(traces, scenario)
    for user in traces.users:
        if (np.diff(user.tick) < 0).any():
            continue  # it was started again
        if (sent := _whole(traces, f"/{user.name}/wave_up")) is not None:
            sums, packets = user.energy["u_tx"], np.append(0.0, sent.energy)
            if f"{user.name}/up" in held_back:  # sums of frames without a packet lie between
                sums, packets = sent.energy[sent.energy <= sums[-1]], np.append(0.0, sums)
            yield from missing(
                f"{user.name}: the energy of u_tx is not that of its packets", sums, packets
            )
        # on the strict channel what arrived is a difference of sums, whatever came of each packet
        received = None if scenario.strict else _whole(traces, f"/{user.name}/wave_down")
        if received is not None and user.name in frames:
            known = np.append(0.0, power(received.wave) * frames[user.name] / 2.0)
            single = np.diff(user.block_time_s) < 1.5 * frames[user.name]
            text = f"{user.name}: the energy of v_rx is not that of packets received"
            yield from missing(text, np.diff(user.energy["v_rx"])[single], known)


def _whole(traces: SessionTraces, topic: str) -> PacketTraces | None:
    """Return the packets on a topic if they are of one sender and none is missing."""
    table = traces.packets.get(topic)
    lost = traces.counts.get(topic, {}).get("missing", 0)
    return table if table is not None and not lost and len(np.unique(table.epoch)) == 1 else None


def no_numbers(owner: str, signals: Mapping[str, Array]) -> Iterator[str]:
    """Yield in words which signals have values that are not finite, or that nothing real has."""
    for name, values in signals.items():
        finite = np.isfinite(values)
        if count := (~finite).sum():
            yield f"{owner}: {name} has {count} values that are not finite"
        if count := (finite & (np.abs(values) > LARGEST)).sum():
            yield f"{owner}: {name} has {count} values beyond {LARGEST:g}"


def server(traces: ServerTraces, scenario: Scenario | None, *, waves: bool) -> Iterator[str]:
    """Yield every contradiction in words."""
    yield from no_numbers("server", {"x_o": traces.x_o, "xd_o": traces.xd_o})
    users = {user.name: user for user in scenario.users} if scenario else {}
    exact = scenario is not None and scenario.coupling.balanced
    for index, name in enumerate(traces.users):
        # steps, from the second on, that follow one on record, the user coupled in both
        coupled = traces.state[index] == Presence.COUPLED
        together = np.asarray((np.diff(traces.step) == 1) & coupled[1:] & coupled[:-1])
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
    if scenario is not None and scenario.environment.movable and not scenario.coupling.black_box:
        kinetic = 0.5 * scenario.server.object_mass * power(traces.xd_o)
        text = "server: the energy of motion is not m |xd|^2/2 of the object"
        yield from off(text, "J", traces.kinetic, kinetic)
    if "withheld" in traces.accounts:
        stored = traces.accounts["environment"] + traces.accounts["contained"] - traces.potential
        text = "server: stored and heat are not what was taken"
        yield from off(text, "J", traces.dissipated, stored)


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
    if known is None:
        return
    most = known.master.rises
    if most == 1.0 or (server.step == np.arange(1, len(server.step) + 1)).all():
        force = root(known.server_impedance / 2.0) * (u - v) * _raised(server, index, most)
        yield from off(f"{name}: F is not sqrt(b/2) (u - v) at the server", "N", f, force, rows)


def _raised(server: ServerTraces, index: int, most: float) -> Array:
    """Return the root of the port's impedance over that of free motion at every step, ``(step,
    1)``: it follows the contact force of the steps before.
    """
    s, found = FREE, []
    force = np.nan_to_num(server.f_s[index]).tolist()
    for f, h in zip(force, server.periods_s.tolist(), strict=True):
        found.append(s.ratio)
        s = followed(s, f, h, most)
    return np.sqrt(found)[:, np.newaxis]


def _grown(server: ServerTraces, account: str) -> Flags:
    """Tell in which steps an account changed."""
    sums = server.accounts.get(account, np.zeros(len(server.time_s)))
    return np.asarray(np.diff(sums, prepend=0.0) != 0.0)


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
