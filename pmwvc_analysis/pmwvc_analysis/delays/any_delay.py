# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability at any constant delay: a proof from the gains of both ends of the link, or why not.

G_i(Theta) is the packet-to-packet response of user i's end (:mod:`.ends`: held device, controller,
filter, rate drop and hold), S(Theta) that of the server's end. Delays turn packets, they add no
gain. If both ends are stable by themselves and

    largest singular value of sqrt|G| S sqrt|G| <= 1    at all frequencies, |G| = diag(|G_i|),

then I - t S G D(Theta) is regular for every delay D and 0 <= t < 1: no eigenvalue ever crosses the
unit circle (Nyquist), the session is stable with any constant delays ("loop rule", while all
contacts touch as the linear model has it). If moreover every |G_i| <= 1 and the server returns no
more energy than it received whatever touches (``implicit``, which conserves energy exactly; a
ledger without allowance), contacts may come and go ("parts rule").

A device held over a tick has |G|^2 - 1 = (2 b T/m)/|1 + b Y|^2 > 0 by itself, so each condition is
one on the whole end: what filter and rate drop lose must cover it at every frequency.

An impedance matrix B = V diag(b) V^T couples the axes: then G_i = V diag(G_i(b)) V^T, and the
same with its absolute value, which commutes with the delays of its user.

Equations: docs/theory.md 14.5, 14.6.
"""

from dataclasses import dataclass

import numpy as np

from pmwvc_analysis.delays.ends import System, master_end, server_end
from pmwvc_analysis.models.linear import axes_of, nonlinear, outside
from pmwvc_core.controllers.library import proofs_hold
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.impedance import eigenvalues, principal_axes

TOLERANCE = 1e-9  # of a gain: below what the exact model calls growth
POINTS = 500
LOWEST = 1e-5  # [rad per packet]
AROUND = np.array([0.0, 0.1, 0.3, 1.0, 3.0, 10.0])  # widths of a pole at which gains are taken
# Parameters of elements that the parts rule covers, or a passive server.
OF_SERVER = ("server.coupling", "compensation", "environment", "server.decoding")
ROUNDS = 4  # of refinement around each maximum
NEAR = 1e-2  # of a gain below the largest: maxima that are refined


@dataclass(frozen=True)
class AnyDelay:
    """The stability at any constant delay, as far as it is known.

    Attributes
    ----------
    proved, reasons
        Whether stability is proved, and why not, with amounts: no proof was found, no more.
    touching
        Whether the proof holds only while all contacts touch.
    gain, at_hz
        Largest gain once around the loop (1 is the limit), and where; None where none was formed.
    """

    proved: bool
    touching: bool
    gain: float | None
    at_hz: float | None
    reasons: tuple[str, ...]


def any_delay(scenario: Scenario, *, live: bool = False) -> AnyDelay | None:
    """Return what is known at any constant delay; None where proofs of wave ports do not hold."""
    if not proofs_hold(scenario.controller):
        return None
    reasons = _outside(scenario)
    if reasons:
        return AnyDelay(False, False, None, None, tuple(reasons))
    period_s = scenario.server.period_s
    ends = [
        [master_end(scenario, user, b, live=live) for b in eigenvalues(user.impedance)]
        for user in scenario.users
    ]
    for user, several in zip(scenario.users, ends, strict=True):
        if not all(_settles(end) for end in several):
            load = max(eigenvalues(user.impedance)) * scenario.tick_s / float(user.device.mass)
            reasons.append(
                f"{user.name}'s end is unstable by itself (b T/m = {load:.3g}; a held device "
                "needs less than 2)"
            )
    server = None if nonlinear(scenario) or outside(scenario) else server_end(scenario)
    if server is not None and not _settles(server):
        largest = float(np.abs(server.poles()).max())
        reasons.append(
            f"the server's end is unstable by itself (it grows {largest:.4g}-fold a step)"
        )
    if reasons:
        return AnyDelay(False, False, None, None, tuple(reasons))
    angle = _angles([end for several in ends for end in several] + ([server] if server else []))
    axes = [principal_axes(user.impedance, axes_of(scenario)) for user in scenario.users]
    masters = Gains(ends, axes, None)
    worst, at = masters.peak(angle)
    at_hz = at / (2.0 * np.pi * period_s)
    passive = scenario.coupling.passive(scenario.server)
    if worst <= 1.0 + TOLERANCE and passive:
        return AnyDelay(True, False, worst, at_hz, ())
    text = f"the users' ends return up to {worst:.7g} times the wave they receive ({at_hz:.3g} Hz)"
    if server is None:
        reasons = [text] if worst > 1.0 + TOLERANCE else []
        if not passive:
            reasons.append("no bound is known for the server's coupling")
        return AnyDelay(False, False, None, None, tuple(reasons))
    gain, at = Gains(ends, axes, server).peak(angle)
    at_hz = at / (2.0 * np.pi * period_s)
    if gain <= 1.0 + TOLERANCE:
        return AnyDelay(True, True, gain, at_hz, ())
    why = f"the gain around the loop is up to 1 + {gain - 1.0:.2g} ({at_hz:.3g} Hz); {text}"
    return AnyDelay(False, False, gain, at_hz, (why,))


class Gains:
    """Gains over frequency: of the users' ends, or once around where there is a server.

    Each user's ends are those along its principal ``axes``, the columns of a matrix.
    """

    def __init__(self, ends: list[list[System]], axes: list[Array], server: System | None) -> None:
        self._ends, self._server = ends, server
        self._axes = axes

    def at(self, angle: Array) -> Array:
        """Return the gain at angles per packet [rad]."""
        z: Complex = np.exp(1j * angle)
        single = [
            np.stack([np.abs(end.response(z)[:, 0, 0]) for end in several], axis=1)
            for several in self._ends
        ]
        if self._server is None:
            return np.asarray(np.concatenate(single, axis=1).max(axis=1))
        dof, users = len(self._axes[0]), len(self._axes)
        blocks = np.zeros((len(z), users, dof, users, dof))
        for user, (gains, axes) in enumerate(zip(single, self._axes, strict=True)):
            blocks[:, user, :, user] = (axes * np.sqrt(gains)[:, np.newaxis]) @ axes.T
        root: Array = blocks.reshape(len(z), users * dof, -1)
        return np.asarray(np.linalg.norm(root @ self._server.response(z) @ root, 2, axis=(1, 2)))

    def peak(self, angle: Array) -> tuple[float, float]:
        """Return the largest gain and the angle where it is, refined beyond the given angles."""
        values = self.at(angle)
        best = int(np.argmax(values))
        found = float(values[best]), float(angle[best])
        inner = np.flatnonzero(
            (values >= np.roll(values, 1))
            & (values >= np.roll(values, -1))
            & (values > found[0] - NEAR)
        )
        for index in inner.tolist():
            low, high = angle[max(index - 1, 0)], angle[min(index + 1, len(angle) - 1)]
            for _ in range(ROUNDS):
                finer = np.linspace(low, high, 21)
                sizes = self.at(finer)
                top = int(np.argmax(sizes))
                found = max(found, (float(sizes[top]), float(finer[top])))
                low, high = finer[max(top - 1, 0)], finer[min(top + 1, 20)]
        return found


def _angles(systems: list[System]) -> Array:
    """Return angles up to pi, denser around every pole."""
    found = [np.geomspace(LOWEST, np.pi, POINTS)]
    for system in systems:
        width = np.maximum(np.abs(1.0 - np.abs(system.poles())), LOWEST)
        found.append(system.angles_near(width, AROUND))
    angle = np.unique(np.concatenate(found))
    return np.asarray(angle[(angle >= LOWEST) & (angle <= np.pi)])


def _settles(system: System) -> bool:
    poles = system.poles()
    return bool(len(poles) == 0 or np.abs(poles).max() < 1.0)


def _outside(scenario: Scenario) -> list[str]:
    """Return what neither rule covers."""
    if scenario.strict:
        return [
            "channel = strict is passive on any network by its account (docs/strict_channel.md); "
            "what follows for stability beyond the exact model is not computed"
        ]
    found = [
        f"{element.text} is not linear"
        for element in nonlinear(scenario)
        if not element.name.endswith(OF_SERVER)
    ]
    for user in scenario.users:
        master, period = user.master, scenario.period_ticks
        if master.position.is_on and not master.position.is_paid:
            found.append(f"{user.name}: the position feedback as published generates energy")
        if (frame := master.rate_drop) != period:
            # the largest energy gain of taking the newest packet, once around
            repeats = -(-frame // period) * period / frame * -(-period // frame) * frame / period
            found.append(
                f"{user.name}: a packet every {master.rate_drop} ticks and a server step every "
                f"{period} repeat or skip packets, which can multiply their energy by up to "
                f"{repeats:.3g}"
            )
    return list(dict.fromkeys(found))
