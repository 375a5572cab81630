# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two ends of a wave link by themselves, at the packet rate: what returns of what arrives.

The master's end takes one packet v a frame and sends one packet u: hold, device and controller at
the tick rate, filter and rate drop lie within, so their aliasing does, too. The server's end takes
a packet u of every user and answers with v. Both are linear and time-invariant from packet to
packet, with no hand on the device.

States that are not read (where a device or the object is) are left out: they do not go round.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.elements import Path
from pmwvc_analysis.models.linearize import Linear, model_of
from pmwvc_analysis.models.links import hyperperiod_ticks
from pmwvc_analysis.models.outside import checked
from pmwvc_analysis.models.variation import changed, with_impedances, with_links
from pmwvc_core.numeric import Array, Complex, Integers
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

POINTS = 21  # of an interval where a maximum is looked for: it then shrinks to a tenth


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


def observable(model: Linear, run: int, out: Any, into: Any) -> tuple[System, int]:
    """Return a run of an open loop from packets that come in to those that go out, without the
    states that neither an output nor another state reads, and how many of those stay where they
    are: eigenvalues 1.
    """
    rows, sent, n = model.rows[run], model.read["sent"][run], len(model.columns)
    inputs, ones = [n + index for index in into], 0
    a, b, c, d = rows[:, :n], rows[:, inputs], sent[out, :n], sent[np.ix_(out, inputs)]
    while len(a):
        read = np.any(c != 0.0, axis=0)
        read |= np.any((a != 0.0) & ~np.eye(len(a), dtype=np.bool_), axis=0)
        if read.all():
            break
        ones += int(np.count_nonzero(np.diag(a)[~read] == 1.0))
        a, b, c = a[np.ix_(read, read)], b[read], c[:, read]
    return System(a, b, c, d), ones


def opened_at(
    runs: Iterable[Scenario],
    ways: Sequence[tuple[str, int]],
    *,
    live: bool = False,
    weights: Sequence[int] = (),
) -> tuple[Linear, list[Path], Integers]:
    """Return a loop whose inputs are packets that come in at links that are cut, and whose output
    ``sent`` are those that go out there instead; what of a packet each of them is; and the number
    of rigid motions of every run while the links are not cut.

    Links are given by their way ("up" or "down") and the number of the user. Their delays are a
    hyperperiod longer than they shall be: so all that is sent there in one is a state.
    """
    loop = checked(*runs, live=live, weights=weights)
    states, paths, rows = list(loop.paths), list(loop.paths.values()), loop.around()[0]
    packets = [
        j for j, path in enumerate(paths) if path[:2] in ways and loop.sent_at(path) >= -loop.ticks
    ]
    motions = model_of(loop, states, rows, {}).quotient[1]
    inside = np.setdiff1d(np.arange(len(states)), packets)
    rows = rows[:, :, [*inside, *packets]]
    sent = {"sent": rows[:, packets]}
    model = model_of(loop, [states[j] for j in inside], rows[:, inside], sent)
    return model, [paths[j] for j in packets], motions


def master_end(scenario: Scenario, user: User, impedance: float, *, live: bool = False) -> System:
    """Return the master's end from the packet v to the packet u sent at the next frame start.

    A frame is as long as a step of the server; there is no linear position feedback: that is no
    wave. The impedance stands in place of the user's: its own, or an eigenvalue of its matrix
    [N s/m].
    """
    alone = with_impedances(user, impedance, None)
    wall = changed(scenario.server, coupling="implicit", environment="wall")
    return ends(changed(scenario, users=(alone,), server=wall, disturbances=""), live=live)[0]


def ends(scenario: Scenario, *, live: bool) -> tuple[System, System]:
    """Return the end of the first user along its first axis, and that of the server from every
    user's packet, by axis, to the answers of the step.
    """
    once = LinkParams(delay_s=(hyperperiod_ticks(scenario) + live) * scenario.tick_s)
    users = range(len(scenario.users))
    ways = [(way, index) for way in ("up", "down") for index in users]
    cut = with_links(scenario, [(once, once) for _ in users])
    model, packets, _ = opened_at([cut], ways, live=live)
    up, down = (
        [j for j, path in enumerate(packets) if path[0] == way and "wave" in path]
        for way in ("up", "down")
    )
    return observable(model, 0, up[:1], down[:1])[0], observable(model, 0, down, up)[0]


def refined(
    at: Callable[[Array], Array], low: float, high: float, *, rounds: int
) -> tuple[float, float]:
    """Return the largest value between two points, and where; ``at`` is of ``(points,)``."""
    found = -np.inf, low
    for _ in range(rounds):
        points = np.linspace(low, high, POINTS)
        values = at(points)
        top = int(np.argmax(values))
        found = max(found, (float(values[top]), float(points[top])))
        low, high = points[max(top - 1, 0)], points[min(top + 1, POINTS - 1)]
    return found
