# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance as measured: from the force and the position that a session recorded.

Cross spectrum of force and position over the power spectrum of the force, both averaged over
overlapping stretches (Welch), with the coherence

    gamma^2 = |S_fx|^2 / (S_ff S_xx),

1 where position follows from force linearly and without noise.

The force is taken as given. A hand that reacts to the motion biases the ratio without a loss of
coherence, by what else moves the device (another hand, noise, a contact that parts). Such sessions
are refused, as are those in which another hand acts.

Equations: docs/theory.md 12.3.
"""

from dataclasses import dataclass

import numpy as np

from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import UserTraces
from pmwvc_core.wave.impedance import MatrixImpedance

STRETCH_S = 8.0  # of the force, for spectra
LEAST_STRETCHES = 3
LEAST_POWER = 1e-3  # of the largest power of the force, for a frequency to count
TRUSTED = 0.9  # coherence above which a value is worth comparing


@dataclass(frozen=True)
class Admittance:
    """Admittance of one user from a recording."""

    user: str
    frequency_hz: Array  # (points,)
    admittance: Complex  # (points,) [m/N]
    coherence: Array  # (points,) 0..1
    stretches: int  # averaged over


def measure(user: UserTraces, known: User) -> Admittance:
    """Return the admittance that a session with a given force shows; PmwvcError if a hand answers,
    the force was not recorded, ticks are missing, or there is too little of it.
    """
    if known.operator.answers or not known.device.is_simulated:
        who = "a person" if not known.device.is_simulated else known.operator.kind
        raise PmwvcError(
            f"{known.name}: the hand ({who}) reacts to the motion of the device: force and "
            "position form a closed loop, in which another hand, noise or a lost contact moves "
            "both, and their ratio is not the admittance; measure with operator.kind=chirp, whose "
            "force is given"
        )
    force, position, acts = user.f_h[:, 0], user.x_m[:, 0], np.flatnonzero(user.f_h[:, 0])
    rows = slice(acts[0], acts[-1] + 1) if len(acts) else slice(0)
    wrong = ""
    if isinstance(known.impedance, MatrixImpedance) and np.any(user.f_h[:, 1:]):
        wrong = (
            "the hand pushes along several axes, which the impedance matrix couples: the motion "
            "along the first is not due to the force along it alone"
        )
    elif not np.isfinite(force).all():
        wrong = (
            "the hand's force was not recorded; an admittance needs a simulated hand or a force "
            "sensor"
        )
    elif not len(acts):
        wrong = "no hand acted; use operator.kind=chirp to measure"
    elif np.any(np.diff(user.tick[rows]) != 1):
        wrong = "ticks are missing in the recording of the hand's force"
    elif known.operator.is_sinusoid:
        wrong = "a sinusoid has one frequency alone; use operator.kind=chirp to measure"
    if wrong:
        raise PmwvcError(f"{user.name}: {wrong}")
    return _spectra(user, force[rows], position[rows], known)


def require_alone(scenario: Scenario, user: int) -> None:
    """Raise PmwvcError where another hand than that of one user acts."""
    for other in scenario.users:
        if other is not scenario.users[user] and other.operator.kind != "none":
            raise PmwvcError(
                f"{other.name}: its hand acts as well, so position and force of "
                f"{scenario.users[user].name} alone do not give the admittance; set "
                f"{other.name}.operator.kind=none"
            )


def _spectra(user: UserTraces, force: Array, position: Array, known: User) -> Admittance:
    from scipy import signal

    length = int(min(STRETCH_S / user.tick_s, 2 * len(force) / (LEAST_STRETCHES + 1)))
    if length * user.tick_s < 0.5:
        raise PmwvcError(
            f"{user.name}: the hand acted for {len(force) * user.tick_s:.2f} s only, too short "
            "for spectra; make the session longer"
        )
    options = {"fs": 1.0 / user.tick_s, "nperseg": length, "detrend": "linear"}
    frequency, power = signal.welch(force, **options)
    _, cross = signal.csd(force, position, **options)
    _, coherence = signal.coherence(force, position, **options)
    asked = power > LEAST_POWER * power.max()
    if known.operator.is_chirp:
        low, high = sorted((known.operator.frequency_hz, known.operator.frequency_end_hz))
        asked &= (frequency >= low) & (frequency <= high)
    asked[:2] = False  # what detrending took
    stretches = int((len(force) - length) // (length // 2)) + 1
    admittance = cross[asked] / power[asked]
    return Admittance(user.name, frequency[asked], admittance, coherence[asked], stretches)
