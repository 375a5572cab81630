# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The contradictions between the numbers of a recording.

At a port with impedance b, F = sqrt(b/2) (u - v) and xd = (u + v)/sqrt(2b) hold for every sample;
so does F xd = (|u|^2 - |v|^2)/2. The running sums that master and server keep have to be the sums
of what they recorded, positions have to follow velocities, and what was sent has to be in the
packets. Of master and server: :mod:`.master`, :mod:`.server`; packets are compared here, where
every one of a sender's life is on record. Where parameters changed in flight, a server is looked
at stage by stage, a master up to its first change. Together with the energy budget they find every
trace that was falsified but those in :func:`..budget.parts.unchecked`.
"""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from pmwvc_analysis.consistency.master import master
from pmwvc_analysis.consistency.numbers import missing, no_numbers, power
from pmwvc_analysis.consistency.server import server
from pmwvc_analysis.traces import cut
from pmwvc_analysis.traces.arrivals import with_deadband
from pmwvc_analysis.traces.stages import Stage, stages
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.frame.rows import SIGNALS
from pmwvc_core.scenario.scenario import Scenario
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
    if traces.server is not None and len(steady) > 1:
        for stage, part in _parts(traces.server, steady):
            found += server(part, stage.scenario, waves=waves)
    elif traces.server is not None:
        found += server(traces.server, scenario, waves=waves)
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
        yield cut.user_until(user, first_s)


def _parts(server: ServerTraces, found: Sequence[Stage]) -> Iterator[tuple[Stage, ServerTraces]]:
    """Yield the steps of each stage, without those next to a change."""
    ends = [stage.start_s for stage in found[1:]] + [np.inf]
    near_s = NEAR_PERIODS * server.period_s
    for stage, end_s in zip(found, ends, strict=True):
        rows = (server.time_s > stage.start_s + near_s) & (server.time_s < end_s - near_s)
        if rows.any():
            yield stage, cut.with_rows(server, rows)


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
