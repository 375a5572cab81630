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
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.linearize import Linear, model_of
from pmwvc_analysis.models.links import CUT
from pmwvc_analysis.models.outside import checked
from pmwvc_analysis.models.variation import with_impedances
from pmwvc_core.numeric import Array, Complex
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

    @property
    def growth(self) -> float:
        """The length of the longest eigenvalue of A; 0 without a state."""
        return float(np.abs(self.poles()).max(initial=0.0))

    def angles_near(self, width: Array, widths: Array) -> Array:
        """Return angles so many widths [rad] before and behind that of every pole."""
        steps = np.multiply.outer(width, np.concatenate([-widths, widths]))
        return np.ravel(np.abs(np.angle(self.poles()))[:, np.newaxis] + steps)

    def response(self, z: Complex) -> Complex:
        """Return y per w ``(points, outputs, inputs)`` at points of the z-plane."""
        resolvent = z[:, np.newaxis, np.newaxis] * np.eye(len(self.a)) - self.a
        driven = np.linalg.solve(resolvent, self.b.astype(np.complex128))
        return np.asarray(self.c @ driven + self.d)


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


def opened_at(loop: Hyperperiod, links: Sequence[tuple[Any, int]]) -> Linear:
    """Return a loop whose inputs are what comes in at links that are cut, and whose output
    ``sent`` is what goes out there instead, both link by link, packet by packet.

    Of each link it is told how many packets are sent in a hyperperiod; the loop is at its
    beginning.
    """
    loop.begin(sum(count for _, count in links) * len(CUT))
    cuts: list[list[Any]] = []
    for link, _ in links:
        cuts.append(loop.cut(link, sum(count for _, count in links[: len(cuts)]) * len(CUT)))
    for tick in range(loop.ticks):
        loop.advance(tick, loop.still)
    sent = [value for cut in cuts for value in cut]
    return model_of(loop, loop.ended(), {"sent": loop.rows(sent)})


def master_end(scenario: Scenario, user: User, impedance: float, *, live: bool = False) -> System:
    """Return the master's end from the packet v to the packet u sent at the next frame start.

    A frame is as long as a step of the server; there is no linear position feedback: that is no
    wave. The impedance stands in place of the user's: its own, or an eigenvalue of its matrix
    [N s/m].
    """
    alone = with_impedances(user, impedance, None)
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
    loop = checked(dataclasses.replace(scenario, users=tuple(users)), live=live)
    links = [(line.up, 1) for line in loop.lines] + [(line.down, 1) for line in loop.lines]
    model = opened_at(loop, links)
    (rows,), (sent,), n = model.rows, model.read["sent"], len(model.columns)
    packet = len(CUT) * loop.dof  # the wave comes first
    up = [packet * user + axis for user in range(len(users)) for axis in range(loop.dof)]
    down = [packet * len(users) + index for index in up]

    def end(out: list[int], into: list[int]) -> System:
        columns = [n + j for j in into]
        whole = System(rows[:, :n], rows[:, columns], sent[out, :n], sent[np.ix_(out, columns)])
        return observable(whole)[0]

    return end(up[:1], down[:1]), end(down, up)
