# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What every controller does at the master's end, in the order of a frame and of a tick.

A member is chosen by the type of its state. ``p`` are the parameters of the port. What has come in
(``arrivals``) belongs to the tick; the strict channel plays its waves out from there.
"""

from pmwvc_core.law.family import Family, same

port_measure = Family("port_measure")  # (s, x, xd, p) -> s: motion at a frame start
# (s, arrivals, frame_s, number, held_j, p) -> (s, arrivals, Sent); held_j: what the brake stores
port_send = Family("port_send")
port_packet = Family("port_packet")  # (s, arrivals, packet, p) -> s: the newest, once a frame
port_answer = Family("port_answer")  # (s, wave, silent, frame_s, p) -> s: its wave, or a silence
port_tick = Family("port_tick")  # (s, arrivals, x, xd, p) -> (s, arrivals, force wanted [N])
port_applied = Family("port_applied")  # (s, f, p) -> s: with the force that the limits let through
port_signals = Family("port_signals")  # (s) -> (u_m, u_m_lp, v_m)
# (s, arrivals, p) -> energies since the start [J]: of u_m, sent, received, v_m, and the port's own
port_energies = Family("port_energies")
port_opened = Family("port_opened", same)  # (s) -> s: lists made here, where a session is compiled
