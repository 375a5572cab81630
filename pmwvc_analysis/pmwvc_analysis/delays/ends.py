# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two ends of a wave link by themselves, at the packet rate: what returns of what arrives.

The master's end takes one packet v a frame and sends one packet u: hold, device and controller at
the tick rate, filter and rate drop lie within, so their aliasing does, too. The server's end takes
a packet u of every user and answers with v. Both are linear and time-invariant from packet to
packet, with no hand on the device.

States that nobody reads (where a device or the object is) are left out: they do not go round.
"""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.models.blocks import Block
from pmwvc_analysis.models.ports import WavePort
from pmwvc_analysis.models.server import Server
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User

Complex = NDArray[np.complex128]


class System(NamedTuple):
    """x+ = A x + B w, y = C x + D w, once a packet."""

    a: Array
    b: Array
    c: Array
    d: Array

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        found: Complex = np.linalg.eigvals(self.a).astype(complex)
        return found

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


def _split(rows: Sequence[Array], outputs: Sequence[Array]) -> System:
    """Return the system whose states and outputs these rows are."""
    n = len(rows)
    width = outputs[0].shape[-1]
    state = np.concatenate([np.zeros((0, width)), *rows])
    out = np.concatenate(list(outputs))
    return observable(System(state[:, :n], state[:, n:], out[:, :n], out[:, n:]))[0]


def _begin(blocks: Sequence[Block], inputs: int) -> Array:
    """Give every state of the blocks its own row; return the rows of the inputs."""
    states = sum(len(block.names) for block in blocks)
    unit = np.eye(states + inputs)
    place = 0
    for block in blocks:
        block.state = [unit[j : j + 1] for j in range(place, place + len(block.names))]
        place += len(block.names)
    return unit[states:]


def master_end(user: User, impedance: float, *, tick_s: float, phase: int = 0) -> System:
    """Return the master's end from the packet v to the packet u sent at the next frame start.

    Parameters
    ----------
    user
        Without a linear position feedback: that is no wave.
    impedance
        In place of the user's: its own, or an eigenvalue of its matrix [N s/m].
    tick_s
        Of the force loop.
    phase
        Tick of the frame at which a packet is taken.
    """
    master = dataclasses.replace(user.master, impedance=impedance, impedance_matrix="")
    port = WavePort(dataclasses.replace(user, master=master), tick_s=tick_s, phase=phase)
    blocks = list(port.blocks.values())
    packet = _begin(blocks, 1)
    sent = port.send()
    nothing = np.zeros_like(packet)
    for tick in range(user.master.rate_drop):
        if tick == phase:
            port.hear([packet], 0)
        port.step(nothing)
    return _split([row for block in blocks for row in block.state], sent)


def server_end(scenario: Scenario) -> System:
    """Return the server's end from every user's packet to the answers of the same step."""
    server = Server(scenario, [1] * len(scenario.users))
    blocks: list[Block] = [server.body, *server.seats]
    packets = _begin(blocks, len(scenario.users))
    answers = server.step([[packets[i : i + 1]] for i in range(len(scenario.users))])
    rows = [row for block in blocks for row in block.state]
    return _split(rows, [answer["v"] for answer in answers])
