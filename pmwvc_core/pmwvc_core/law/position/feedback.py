# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback as the ports of a master see it; by default there is none.

Order: once a frame ``position_packet`` (the newest packet, with the avatar's position), then
``position_there`` (whether the server is); every tick ``position_down`` and ``position_up``;
``position_send`` at a frame start. On the plain channel the feedback pays for what it sends and
gives out; on the strict channel the node does.
"""

from pmwvc_core.law.family import Family, no_accounts, none_j, passed, same

position_packet = Family("position_packet", same)  # (s, packet, p) -> s
position_there = Family("position_there", same)  # (s, there) -> s
# (s, v, x, free_j, waiting, p) -> (s, v): free_j of the node, and the integral that the playout
# holds [sqrt(W) s], on the strict channel
position_down = Family("position_down", passed)
position_up = Family("position_up", same)  # (s, u, f, xd, p) -> s: the wave of a tick that goes on
position_send = Family("position_send", passed)  # (s, wave, number, frame_s, p) -> (s, wave)
position_lent = Family("position_lent", none_j)  # (s, p) -> energy lent at the start [J]
position_opened = Family("position_opened", same)  # (s) -> s, its lists made here
# (s) -> sums and levels [J], as they are named
position_energies = Family("position_energies", no_accounts)
