# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What happens to the users of a server beside its steps: all leave, packets are counted while
nothing is stepped, a sender is asked to prove itself.
"""

from collections.abc import Sequence

from pmwvc_core.law.channel.arrivals import arrive, waits
from pmwvc_core.law.channel.packet import About, Packet, Sent, pack
from pmwvc_core.law.server.server_port import left
from pmwvc_core.law.server_step import ABSENT, Server, ServerStepParams
from pmwvc_core.law.vectors import zero


def all_left(s: Server) -> Server:
    """Take all users out; what their springs hold is lost."""
    e = s.environment
    ports, dropped_j = zip(*map(left, e.ports), strict=True)
    e = e._replace(ports=ports, dissipated_j=e.dissipated_j + sum(dropped_j))
    guests = tuple(guest._replace(presence=ABSENT) for guest in s.guests)
    return s._replace(guests=guests, environment=e)


def counted(
    s: Server, p: ServerStepParams, now_ns: int, packets: Sequence[list[Packet]]
) -> Server:
    """Count what comes while nothing is stepped."""
    guests = []
    for guest, rules, taken in zip(s.guests, p.guests, packets, strict=True):
        arrivals = guest.arrivals
        for packet in taken:
            arrivals = arrive(arrivals, packet, now_ns, rules.arrivals)
        guests.append(guest._replace(arrivals=arrivals))
    return s._replace(guests=tuple(guests))


def challenge(s: Server, p: ServerStepParams, user: int, now_ns: int) -> tuple[Server, Packet]:
    """Return a packet of nothing, which an answer has to echo."""
    guest, port = s.guests[user], s.environment.ports[user]
    rest = zero(port.x_s)
    about = About(now_ns, False, waits(guest.arrivals), guest.anew, False, 0, 1)
    sent = Sent(rest, rest, port.account_j, port.extra)
    packing, packet, _ = pack(guest.packing, sent, p.period_s, about, p.guests[user].packing)
    guests = list(s.guests)
    guests[user] = guest._replace(packing=packing)
    return s._replace(guests=tuple(guests)), packet
