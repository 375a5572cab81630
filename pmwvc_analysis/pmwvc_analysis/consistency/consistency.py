# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the numbers of a recording fit each other.

At a port with impedance b, F = sqrt(b/2) (u - v) and xd = (u + v)/sqrt(2b) hold for every sample;
so does F xd = (|u|^2 - |v|^2)/2. The running sums that master and server keep have to be the sums
of what they recorded, positions have to follow velocities, and what was sent has to be in the
packets. The checks: :mod:`.consistency_master`, :mod:`.consistency_server`,
:mod:`.consistency_packets`. Together with the energy budget they find every trace that was
falsified but those in :data:`.remainders.UNCHECKED`.
"""

from pmwvc_analysis.consistency import consistency_packets, consistency_server
from pmwvc_analysis.consistency.consistency_master import master
from pmwvc_analysis.consistency.numbers import not_finite
from pmwvc_core.controllers import has_waves
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

MASTER_SIGNALS = ("x_m", "xd_m", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")


def inconsistencies(traces: SessionTraces, scenario: Scenario | None) -> list[str]:
    """Return every contradiction in words."""
    found = []
    users = {user.name: user for user in scenario.users} if scenario else {}
    waves = scenario is None or has_waves(scenario.controller)
    simulated = traces.source == "simulated"
    for user in traces.users:
        found += not_finite(user.name, {n: getattr(user, n) for n in MASTER_SIGNALS})
        known = users.get(user.name)
        found += master(user, known, waves=waves, simulated=simulated)
    if traces.server is not None:
        found += consistency_server.server(traces.server, scenario, waves=waves)
    return found + consistency_packets.packets(traces, scenario, waves=waves)
