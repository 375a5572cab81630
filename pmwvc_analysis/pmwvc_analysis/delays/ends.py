# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two ends of a wave link by themselves, at the packet rate: what returns of what arrives.

The master's end takes one packet v a frame and sends one packet u: hold, device and controller at
the tick rate, filter and rate drop lie within, so their aliasing does, too. The server's end takes
a packet u of every user and answers with v. Both are linear and time-invariant from packet to
packet, with no hand on the device.

States that are not read (where a device or the object is) are left out: they do not go round.
"""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.linearize import Linear, model_of
from pmwvc_analysis.models.links import SIGNALS, Link, Packet
from pmwvc_analysis.models.outside import loop_of
from pmwvc_core.numeric import Array, Complex, Value
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User


class System(NamedTuple):
    """x+ = A x + B w, y = C x + D w, once a packet."""

    a: Array
    b: Array
    c: Array
    d: Array

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.a).astype(complex))

    def angles_near(self, width: Array, widths: Array) -> Array:
        """Return angles so many widths [rad] before and behind that of every pole."""
        steps = np.multiply.outer(width, np.concatenate([-widths, widths]))
        return np.ravel(np.abs(np.angle(self.poles()))[:, np.newaxis] + steps)

    def response(self, z: Complex) -> Complex:
        """Return y per w ``(points, outputs, inputs)`` at points of the z-plane."""
        states = len(self.a)
        if states == 0:
            return np.tile(self.d.astype(np.complex128), (len(z), 1, 1))
        resolvent = z[:, np.newaxis, np.newaxis] * np.eye(states) - self.a
        driven = np.linalg.solve(resolvent, np.tile(self.b.astype(np.complex128), (len(z), 1, 1)))
        found: Complex = np.asarray(self.c @ driven + self.d, dtype=np.complex128)
        return found


def observable(system: System) -> tuple[System, int]:
    """Return the system without the states that neither an output nor another state reads, and how
    many of those stay where they are: eigenvalues 1.
    """
    a, b, c, d = system
    ones = 0
    while len(a):
        read = np.any(c != 0.0, axis=0)
        read |= np.any((a != 0.0) & ~np.eye(len(a), dtype=np.bool_), axis=0)
        if read.all():
            break
        ones += int(np.count_nonzero(np.diag(a)[~read] == 1.0))
        a, b, c = a[np.ix_(read, read)], b[read], c[:, read]
    return System(a, b, c, d), ones


class _Cut:
    """A link that is cut: keeps what is sent and hands out inputs of the loop instead."""

    def __init__(self, loop: Hyperperiod, first: int) -> None:
        self.sent: list[Value] = []
        self._loop, self._first = loop, first

    def __call__(self, packet: Packet) -> Packet:
        index = self._first + len(self.sent)
        self.sent += packet
        return tuple(self._loop.batch.input(index + i) for i in range(len(packet)))


def opened_at(loop: Hyperperiod, links: Sequence[tuple[Link, int]]) -> Linear:
    """Return a loop whose inputs are what comes in at links that are cut, and whose output
    ``sent`` is what goes out there instead, both link by link, packet by packet.

    Of each link it is told how many packets are sent in a hyperperiod; the loop is at its
    beginning.
    """
    loop.begin(sum(count for _, count in links) * len(SIGNALS))
    cuts: list[_Cut] = []
    for link, _ in links:
        cuts.append(_Cut(loop, sum(count for _, count in links[: len(cuts)]) * len(SIGNALS)))
        link.relay = cuts[-1]
    for tick in range(loop.ticks):
        loop.advance(tick, [0.0] * len(loop.lines))
    return model_of(
        loop, loop.ended(), {"sent": loop.batch.rows([v for cut in cuts for v in cut.sent])}
    )


def master_end(scenario: Scenario, user: User, impedance: float, *, live: bool = False) -> System:
    """Return the master's end from the packet v to the packet u sent at the next frame start.

    A frame is as long as a step of the server; there is no linear position feedback: that is no
    wave. The impedance stands in place of the user's: its own, or an eigenvalue of its matrix
    [N s/m].
    """
    master = dataclasses.replace(user.master, impedance=impedance, impedance_matrix="")
    contact = dataclasses.replace(user.contact, impedance=None, impedance_matrix="")
    alone = dataclasses.replace(user, master=master, contact=contact)
    wall = dataclasses.replace(scenario.server, coupling="implicit", environment="wall")
    one = dataclasses.replace(scenario, users=(alone,), server=wall, disturbances="")
    return _ends(one, live=live)[0]


def server_end(scenario: Scenario) -> System:
    """Return the server's end from every user's packet, by axis, to the answers of the step."""
    return _ends(scenario, live=False)[1]


def _ends(scenario: Scenario, *, live: bool) -> tuple[System, System]:
    """Return the end of the first user along its first axis, and that of the server."""
    at_once = LinkParams()
    users = [
        dataclasses.replace(user, link_up=at_once, link_down=at_once) for user in scenario.users
    ]
    loop = loop_of(dataclasses.replace(scenario, users=tuple(users)), live=live)
    links = [(line.up, 1) for line in loop.lines] + [(line.down, 1) for line in loop.lines]
    model = opened_at(loop, links)
    (rows,), (sent,), n = model.rows, model.outputs["sent"], len(model.columns)
    packet = len(SIGNALS) * loop.dof  # the wave comes first
    up = [packet * user + axis for user in range(len(users)) for axis in range(loop.dof)]
    down = [packet * len(users) + index for index in up]

    def end(out: list[int], into: list[int]) -> System:
        columns = [n + j for j in into]
        whole = System(rows[:, :n], rows[:, columns], sent[out, :n], sent[np.ix_(out, columns)])
        return observable(whole)[0]

    return end(up[:1], down[:1]), end(down, up)
