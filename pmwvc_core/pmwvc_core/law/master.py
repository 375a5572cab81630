# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What every controller does at the master's end, in the order of a frame and of a tick.

A member is chosen by the type of its state. ``p`` are the parameters of the port.
"""

from pmwvc_core.law.family import Family

port_measure = Family("port_measure")  # (s, x, xd, p) -> s: motion at a frame start
port_send = Family("port_send")  # (s, frame_s, number, held_j, p) -> (s, Sent)
port_packet = Family("port_packet")  # (s, packet, p) -> s: the newest packet, once a frame
port_answer = Family("port_answer")  # (s, wave, silent, frame_s, p) -> s: its wave, or a silence
port_tick = Family("port_tick")  # (s, x, xd, p) -> (s, force wanted [N])
port_applied = Family("port_applied")  # (s, f, p) -> s: with the force that the limits let through
