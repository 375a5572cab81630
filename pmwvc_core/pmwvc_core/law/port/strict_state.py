# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""State and parameters of the master's port on the strict channel (:mod:`.strict_master`)."""

from typing import Any, NamedTuple

from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.port.counts import Counts
from pmwvc_core.law.vectors import Vector


class Node(NamedTuple):
    """Energies at the device's node [J]."""

    node_j: float  # came in from both sides and is not paid to a packet yet
    deficit_j: float  # packets needed it and have not been paid with it yet
    withheld_j: float  # for rough counts
    due_j: float  # what the next packet needs at most, with position feedback


class StrictEnergies(NamedTuple):
    """Running sums [J]: u_m, sent, v_m."""

    u_m: float
    u_tx: float
    v_m: float


class Under(NamedTuple):
    """The tick under way: how it began, until it is settled when it is over."""

    v: Vector  # of the playout [sqrt(W)]
    f: Vector  # applied [N]
    settled: bool
    begun: bool  # ever


class StrictMaster(NamedTuple):
    """The wave port of a device on the strict channel."""

    node: Node
    filters: Any
    position: Any
    waves: tuple[Vector, Vector, Vector]  # u_m, u after the filters, v_m [sqrt(W)]
    x: Vector  # [m] last good one
    xd: Vector  # [m/s] for the force
    counts: tuple[Counts, ...]  # of every axis
    integral: Vector  # of u since the frame began [sqrt(W) s]
    under: Under
    unpaid: float  # integral sent without its energy while the server is short [sqrt(W) s]
    asks: tuple[bool, bool]  # energy is wanted at the other end, is short here
    energies: StrictEnergies


class StrictMasterParams(NamedTuple):
    """Impedance, tick [s], and the parameters of the parts."""

    impedance: Any
    tick_s: float
    filters: Any
    position: Any
    lends: bool  # whether the position feedback borrowed from the node
    playout: PlayoutParams
