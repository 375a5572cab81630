# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A server that stood still: the playout of a user who is there passes by that time."""

from support.plain import load

from pmwvc_core.law.channel.packet import Deadband, Packing, Sent, pack
from pmwvc_core.law.server_step import server_step
from pmwvc_core.made.server import resting_server, server_params

PERIOD_NS = 8_000_000


REST, SENT = (0.0,), Sent((0.1,), (0.0,), -1.0, (), 0)
ALWAYS = Deadband(-1.0, 0.0)


def stepped(server, packing, params, missed_s=0.0):
    """Return the server after a step in which the next packet came, and the sender."""
    now_ns = packing.number * PERIOD_NS
    about = 1e-9 * PERIOD_NS, now_ns, (False, False), False, False, 0, 0, ALWAYS
    packing, packet, _ = pack(packing, SENT, *about)
    return server_step(server, now_ns, ([packet],), missed_s, params)[0], packing


def test_a_playout_passes_by_the_time_that_the_server_lost():
    scenario = load("wall", settings_texts=["channel=strict"])
    params = server_params(scenario.users, scenario, scenario.server)
    server = resting_server(scenario.users, scenario, params)
    packing = Packing(REST, REST, REST)
    for _ in range(8):
        server, packing = stepped(server, packing, params)
    went_on, _ = stepped(server, packing, params)
    stood, _ = stepped(server, packing, params, missed_s=0.1)
    (one,), (other,) = went_on.guests, stood.guests
    assert other.arrivals.playout != one.arrivals.playout
    assert other.arrivals.playout.pace.store_s < one.arrivals.playout.pace.store_s
