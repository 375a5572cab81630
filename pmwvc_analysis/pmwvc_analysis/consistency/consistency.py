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
from pmwvc_analysis.consistency.numbers import missing_from, no_numbers
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
    found = []
    users = {user.name: user for user in scenario.users} if scenario else {}
    waves = scenario is None or has_waves(scenario.controller)
    strict = scenario is not None and scenario.strict
    steady = stages(traces, scenario) if scenario else []
    for user in traces.users:
        found += no_numbers(user.name, {n: getattr(user, n) for n in SIGNALS if n != "f_h"})
        known = users.get(user.name)
        for same in _before_change(user, traces, steady):
            found += master(same, known, waves=waves, strict=strict, simulated=traces.simulated)
    if traces.server is not None and len(steady) > 1:
        for stage, part in _parts(traces.server, steady):
            found += server(part, stage.scenario, waves=waves)
    elif traces.server is not None:
        found += server(traces.server, scenario, waves=waves)
    return list(dict.fromkeys(found)) + _packets(traces, scenario, waves=waves)


def _before_change(
    user: UserTraces, traces: SessionTraces, found: Sequence[Stage]
) -> Iterator[UserTraces]:
    """Yield the trace of a master up to the first change of its parameters."""
    first_s = np.inf
    for before, after in itertools.pairwise(found):
        pairs = zip(before.scenario.users, after.scenario.users, strict=True)
        own = [(one, two) for one, two in pairs if one.name == user.name]
        if any(one.master is not two.master or one.safety is not two.safety for one, two in own):
            first_s = min(first_s, after.start_s - 2.0 * own[0][0].master.frame_s)
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


def _packets(traces: SessionTraces, scenario: Scenario | None, *, waves: bool) -> list[str]:
    """Return every contradiction in words."""
    if not waves or scenario is None:
        return []
    found = []
    frames = {user.name: user.master.frame_s for user in scenario.users}
    held_back = with_deadband(traces, scenario)
    for user in traces.users:
        sent = _whole(traces, f"/{user.name}/wave_up")
        if sent is not None and not (np.diff(user.tick) < 0).any():
            sums, packets = user.energy["u_tx"], np.append(0.0, sent.energy)
            if f"{user.name}/up" in held_back:  # sums of frames without a packet lie between
                sums, packets = sent.energy[sent.energy <= sums[-1]], np.append(0.0, sums)
            if (gap := missing_from(sums, np.sort(packets))) is not None:
                found.append(
                    f"{user.name}: the energy of u_tx is not that of its packets, {gap:.3g} J off"
                )
        if scenario.strict:  # what arrived is a difference of sums, whatever came of each packet
            continue
        received = _whole(traces, f"/{user.name}/wave_down")
        if received is not None and user.name in frames and not (np.diff(user.tick) < 0).any():
            power = np.sum(received.wave**2, axis=-1) * frames[user.name] / 2.0
            known = np.sort(np.concatenate([[0.0], power]))
            gained = np.diff(user.energy["v_rx"])
            single = np.diff(user.block_time_s) < 1.5 * frames[user.name]
            if (gap := missing_from(gained[single], known)) is not None:
                found.append(
                    f"{user.name}: the energy of v_rx is not that of packets received, "
                    f"{gap:.3g} J off"
                )
    return found


def _whole(traces: SessionTraces, topic: str) -> PacketTraces | None:
    """Return the packets on a topic if they are of one sender and none is missing."""
    table = traces.packets.get(topic)
    if table is None or len(table.seq) == 0:
        return None
    if traces.counts.get(topic, {}).get("missing", 0) or len(np.unique(table.epoch)) > 1:
        return None
    return table
