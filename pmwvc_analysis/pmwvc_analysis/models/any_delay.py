# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability at any constant delay: a proof from the gains of both ends of the link, or why not.

G_i(Theta) is the packet-to-packet response of user i's end, S(Theta) that of the server's end
(:func:`.matrices.matrices`). Delays turn packets, they add no gain. If both ends are stable by
themselves and

    largest singular value of sqrt|G| S sqrt|G| <= 1    at all frequencies, |G| = diag(|G_i|),

then I - t S G D(Theta) is regular for every delay D and 0 <= t < 1: no eigenvalue ever crosses the
unit circle (Nyquist), the session is stable with any constant delays ("loop rule", while all
contacts touch as the linear model has it). If moreover every |G_i| <= 1 and the server returns no
more energy than it received whatever touches (``implicit``; a ledger without allowance), contacts
may come and go ("parts rule"). A device held over a tick has |G|^2 - 1 = (2 b T/m)/|1 + b Y|^2 > 0
by itself: what filter and rate drop lose must cover it at every frequency.

An impedance matrix couples the axes: then G_i is a matrix, with |G_i| = sqrt(G_i^H G_i) of the
same axes, which commutes with the delays of its user.

Equations: docs/theory.md 14.5, 14.6.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import axes_of, nonlinear, outside
from pmwvc_analysis.models.matrices import matrices, reduced
from pmwvc_analysis.models.variation import changed
from pmwvc_core.controllers.library import proofs_hold
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.aliasing import peak

TOLERANCE = 1e-9  # of a gain: below what the exact model calls growth
POINTS = 500
LOWEST = 1e-5  # [rad per packet]
AROUND = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0)  # widths of a pole at which gains are taken
# Parameters of elements that the parts rule covers, or a passive server.
OF_SERVER = ("server.coupling", "compensation", "environment", "server.decoding")
NEAR = 1e-2  # of a gain below the largest: maxima that are refined


class AnyDelay(NamedTuple):
    """The stability at any constant delay, as far as it is known."""

    proved: bool
    reasons: tuple[str, ...] = ()  # why no proof was found, with amounts
    touching: bool = False  # the proof holds only while all contacts touch
    gain: float | None = None  # largest once around the loop, 1 is the limit; None: none formed


class PacketEnd(NamedTuple):
    """What an end with n states sends of packets that come in, [A, B; C, D]."""

    matrix: Array
    n: int

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.matrix[: self.n, : self.n]).astype(complex))

    def response(self, z: Complex) -> Complex:
        """Return what goes out per what comes in ``(points, outputs, inputs)``."""
        n, whole = self.n, self.matrix
        resolvent = z[:, np.newaxis, np.newaxis] * np.eye(n) - whole[:n, :n]
        driven = np.linalg.solve(resolvent, whole[:n, n:].astype(np.complex128))
        return np.asarray(whole[n:, :n] @ driven + whole[n:, n:])


def any_delay(scenario: Scenario, *, live: bool = False) -> AnyDelay | None:
    """Return what is known at any constant delay; None where proofs of wave ports do not hold, and
    on the strict channel, whose account of every packet makes it passive on any network.
    """
    if scenario.strict or not proofs_hold(scenario.controller):
        return None
    if reasons := _outside(scenario):
        return AnyDelay(False, reasons)
    users = scenario.users
    at_wall = changed(scenario.server, coupling="implicit", environment="wall")
    masters = _ends(changed(scenario, server=at_wall, disturbances=""), live=live)[:-1]
    server = None if nonlinear(scenario) or outside(scenario) else _ends(scenario, live=False)[-1]
    ends = {f"{user.name}'s": end for user, end in zip(users, masters, strict=True)}
    ends |= {"the server's": server} if server else {}
    grows = (n for n, end in ends.items() if np.abs(end.poles()).max(initial=0.0) >= 1.0)
    if unstable := tuple(f"{name} end is unstable by itself" for name in grows):
        return AnyDelay(False, unstable)
    every = [np.geomspace(LOWEST, np.pi, POINTS)]  # denser around every pole
    for end in ends.values():
        poles = end.poles()
        width, turn = np.maximum(np.abs(1.0 - np.abs(poles)), LOWEST), np.abs(np.angle(poles))
        every += [turn + side * each * width for each in AROUND for side in (-1.0, 1.0)]
    angle = np.unique(np.concatenate(every))
    angle = angle[(angle >= LOWEST) & (angle <= np.pi)]
    hertz = 1.0 / (2.0 * np.pi * scenario.server.period_s)

    def gains(angle: Array) -> list[Complex]:
        """Return |G|^2 of each user's end ``(points, axes, axes)``."""
        found = [end.response(np.exp(1j * angle)) for end in masters]
        return [g.conj().swapaxes(1, 2) @ g for g in found]

    def single(angle: Array) -> Array:
        """Return the largest gain of a user's end."""
        sizes = [np.linalg.norm(squared, 2, axis=(1, 2)) for squared in gains(angle)]
        return np.asarray(np.sqrt(np.max(sizes, axis=0)))

    worst, at = _peak(single, angle)
    lossless, passive = worst <= 1.0 + TOLERANCE, scenario.coupling.passive(scenario.server)
    if lossless and passive:
        return AnyDelay(True, gain=worst)
    text = (
        f"the users' ends return up to {worst:.7g} times the wave they receive "
        f"({at * hertz:.3g} Hz)"
    )
    if server is None:
        unknown = () if passive else ("no bound is known for the server's coupling",)
        return AnyDelay(False, (*(() if lossless else (text,)), *unknown))

    def around(angle: Array) -> Array:
        """Return the gain once around the loop."""
        whole = server.response(np.exp(1j * angle))
        for user, squared in enumerate(gains(angle)):
            sizes, axes = np.linalg.eigh(squared)
            root = (axes * np.maximum(sizes, 0.0)[:, np.newaxis] ** 0.25) @ axes.conj().swapaxes(
                1, 2
            )
            own = slice(user * len(sizes[0]), (user + 1) * len(sizes[0]))
            whole[:, own] = root @ whole[:, own]
            whole[:, :, own] = whole[:, :, own] @ root
        return np.asarray(np.linalg.norm(whole, 2, axis=(1, 2)))

    gain, at = _peak(around, angle)
    if gain <= 1.0 + TOLERANCE:
        return AnyDelay(True, touching=True, gain=gain)
    why = f"the gain around the loop is up to 1 + {gain - 1.0:.2g} ({at * hertz:.3g} Hz); {text}"
    return AnyDelay(False, (why,), gain=gain)


def _ends(scenario: Scenario, *, live: bool) -> list[PacketEnd]:
    """Return every end, users before the server, from packets that come in to those sent."""
    at_once = LinkParams(delay_s=live * scenario.tick_s)
    users = (changed(user, link_up=at_once, link_down=at_once) for user in scenario.users)
    found = []
    for end, _ in matrices([changed(scenario, users=tuple(users))], live):
        n = len(end.states)
        into, out = (
            [n + at for at, (_, number) in enumerate(signals) if number < axes_of(scenario)]
            for signals in (end.came, end.sent)
        )
        waves = end.matrix[:, np.r_[:n, out]][:, :, np.r_[:n, into]]
        kept, rows = reduced(waves, np.zeros(n, dtype=np.bool_))
        found.append(PacketEnd(rows[0], len(kept)))
    return found


def _peak(gain: Callable[[Array], Array], angle: Array) -> tuple[float, float]:
    """Return the largest gain over angles per packet [rad], and where, refined between them."""
    values = gain(angle)
    best = int(np.argmax(values))
    found = float(values[best]), float(angle[best])
    sides = np.maximum(np.roll(values, 1), np.roll(values, -1))
    for index in np.flatnonzero((values >= sides) & (values > found[0] - NEAR)).tolist():
        place, most = peak(gain, angle[max(index - 1, 0) : index + 2])
        found = max(found, (most, place))
    return found


def _outside(scenario: Scenario) -> tuple[str, ...]:
    """Return what neither rule covers."""
    found = [
        f"{element.text} is not linear"
        for element in nonlinear(scenario)
        if not element.name.endswith(OF_SERVER)
    ]
    period = scenario.period_ticks
    for user in scenario.users:
        position, frame = user.master.position, user.master.rate_drop
        if position.is_on and not position.is_paid:
            found.append(f"{user.name}: the position feedback as published generates energy")
        if frame != period:
            steps = f"a packet every {frame} ticks and a server step every {period}"
            found.append(f"{user.name}: {steps} repeat or skip packets, with their energy")
    return tuple(dict.fromkeys(found))
