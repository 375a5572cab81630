# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback as the ports of a master see it, and the port without any.

Order: once a frame ``position_packet`` (the newest packet, with the avatar's position), then
``position_there`` (whether the server is); every tick ``position_down`` and ``position_up``;
``position_send`` at a frame start. On the plain channel the feedback pays for what it sends and
gives out; on the strict channel the node does.
"""

from typing import NamedTuple

from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector

position_packet = Family("position_packet")  # (s, packet, p) -> s
position_there = Family("position_there")  # (s, there) -> s
# (s, v, x, free_j, waiting, p) -> (s, v): free_j of the node, and the integral that the playout
# holds [sqrt(W) s], on the strict channel
position_down = Family("position_down")
position_up = Family("position_up")  # (s, u, f, xd, p) -> s: the wave of a tick that goes on
position_send = Family("position_send")  # (s, wave, number, frame_s, p) -> (s, wave)
position_lent = Family("position_lent")  # (s, p) -> energy lent at the start [J]
position_opened = Family("position_opened")  # (s) -> s, its lists made here
position_energies = Family("position_energies")  # (s) -> sums and levels [J], as they are named


class NoPosition(NamedTuple):
    """No position feedback."""

    none: int


@position_packet.member(NoPosition)
def _packet(s: NoPosition, packet: Packet, p: NoPosition) -> NoPosition:
    return s


@position_there.member(NoPosition)
def _there(s: NoPosition, there: bool) -> NoPosition:
    return s


@position_down.member(NoPosition)
def _down(
    s: NoPosition, v: Vector, x: Vector, free_j: float, waiting: Vector, p: NoPosition
) -> tuple[NoPosition, Vector]:
    return s, v


@position_up.member(NoPosition)
def _up(s: NoPosition, u: Vector, f: Vector, xd: Vector, p: NoPosition) -> NoPosition:
    return s


@position_send.member(NoPosition)
def _send(
    s: NoPosition, wave: Vector, number: int, frame_s: float, p: NoPosition
) -> tuple[NoPosition, Vector]:
    return s, wave


@position_lent.member(NoPosition)
def _lent(s: NoPosition, p: NoPosition) -> float:
    return 0.0


@position_energies.member(NoPosition)
def _energies(s: NoPosition) -> Vector:
    return ()


@position_opened.member(NoPosition)
def _opened(s: NoPosition) -> NoPosition:
    return s
