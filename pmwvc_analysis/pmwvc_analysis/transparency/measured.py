# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance as measured: from the force and the position that a session recorded.

Broad-band forces (a chirp): cross spectrum of force and position over the power spectrum of the
force, both averaged over overlapping stretches (Welch), with the coherence

    gamma^2 = |S_fx|^2 / (S_ff S_xx),

1 where position follows from force linearly and without noise. A single sine: the ratio of both at
its frequency, stretch by stretch; their coherence is |mean(X F*)|^2 / (mean |X|^2 mean |F|^2).

Both take the force as given. A hand that reacts to the motion biases the ratio without a loss of
coherence, by what else moves the device (another hand, noise, a contact that parts). Such sessions
are refused, as are those in which another user answers or pushes in a way of its own.

Equations: docs/theory.md 12.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Complex, Integers
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import UserTraces
from pmwvc_core.wave.impedance import MatrixImpedance

STRETCH_S = 8.0  # of the force, for spectra
LEAST_STRETCHES = 3
SETTLE_S = 1.0  # of a sine, before it counts
ALIKE = 0.01  # of a user's force: what another's may differ from a multiple of it
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
    _require_given(known)
    force, position, rows = user.f_h[:, 0], user.x_m[:, 0], _acting(user)
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
    elif rows is None:
        wrong = "no hand acted; use operator.kind=chirp (or sinusoid) to measure"
    elif np.any(np.diff(user.tick[rows]) != 1):
        wrong = "ticks are missing in the recording of the hand's force"
    if wrong or rows is None:
        raise PmwvcError(f"{user.name}: {wrong}")
    how = _at_one_frequency if known.operator.is_sinusoid else _over_frequency
    return how(user, force[rows], position[rows], known)


def pattern(users: Sequence[UserTraces], scenario: Scenario, index: int) -> list[float]:
    """Return what every user pushed per unit of the force of the one looked at; PmwvcError if
    another hand answers, was not recorded, or pushed in a way of its own.
    """
    own = {user.name: user for user in users}
    name = scenario.users[index].name
    ticks, force = _swing(own[name])
    power = float(force @ force)
    found = []
    for known in scenario.users:
        if known.name == name:
            found.append(1.0)
            continue
        _require_given(known)
        other = own.get(known.name)
        at, pushed = (ticks, 0.0 * force) if other is None else _swing(other)
        _, here, there = np.intersect1d(ticks, at, return_indices=True)
        ratio = float(force[here] @ pushed[there]) / power if power > 0.0 else 0.0
        rest = pushed[there] - ratio * force[here]
        if not np.isfinite(rest).all() or rest @ rest > ALIKE**2 * power:
            raise PmwvcError(
                f"{known.name}: its force is not a multiple of that of {name}, so position and "
                "force of one user alone do not give the admittance; set "
                f"{known.name}.operator.kind=none"
            )
        found.append(ratio)
    return found


def _swing(user: UserTraces) -> tuple[Integers, Array]:
    """Return ticks and force without its mean, from where the hand acts."""
    force, rows = user.f_h[:, 0], _acting(user) or slice(None)
    return user.tick[rows], force[rows] - force[rows].mean()


def _acting(user: UserTraces) -> slice | None:
    """Return the rows from where the hand acts to where it ends; None where it never does."""
    acts = np.flatnonzero(user.f_h[:, 0])
    return slice(int(acts[0]), int(acts[-1]) + 1) if len(acts) else None


def _require_given(known: User) -> None:
    if known.operator.answers or not known.device.is_simulated:
        who = "a person" if not known.device.is_simulated else known.operator.kind
        raise PmwvcError(
            f"{known.name}: the hand ({who}) reacts to the motion of the device: force and "
            "position form a closed loop, in which another hand, noise or a lost contact moves "
            "both, and their ratio is not the admittance; measure with operator.kind=chirp (or "
            "sinusoid), whose force is given"
        )


def _over_frequency(user: UserTraces, force: Array, position: Array, known: User) -> Admittance:
    from scipy import signal

    length = int(min(STRETCH_S / user.tick_s, 2 * len(force) / (LEAST_STRETCHES + 1)))
    if length * user.tick_s < 0.5:
        raise PmwvcError(
            f"{user.name}: the hand acted for {len(force) * user.tick_s:.2f} s only, too short "
            "for spectra; make the session longer"
        )
    options = {"fs": 1.0 / user.tick_s, "nperseg": length, "detrend": "linear"}
    frequency, power = signal.welch(force, **options)
    _, moved = signal.welch(position, **options)
    _, cross = signal.csd(force, position, **options)
    asked = power > LEAST_POWER * power.max()
    if known.operator.is_chirp:
        low, high = sorted((known.operator.frequency_hz, known.operator.frequency_end_hz))
        asked &= (frequency >= low) & (frequency <= high)
    asked[:2] = False  # what detrending took
    stretches = int((len(force) - length) // (length // 2)) + 1
    return _ratio(user, frequency[asked], cross[asked], power[asked], moved[asked], stretches)


def _at_one_frequency(user: UserTraces, force: Array, position: Array, known: User) -> Admittance:
    """Return the one value, from stretches of whole periods."""
    frequency_hz = float(known.operator.frequency_hz)
    settled = round(SETTLE_S / user.tick_s)
    force, position = force[settled:], position[settled:]
    duration = len(force) * user.tick_s
    if frequency_hz <= 0.0 or duration * frequency_hz < LEAST_STRETCHES:
        raise PmwvcError(
            f"{user.name}: less than {LEAST_STRETCHES} periods of {frequency_hz:g} Hz were "
            "recorded; make the session longer"
        )
    per_stretch = max(1, int(duration * frequency_hz) // 8)
    length = round(per_stretch / frequency_hz / user.tick_s)
    stretches = len(force) // length
    angle = 2.0 * np.pi * frequency_hz * user.tick_s * np.arange(length)
    basis = np.stack([np.cos(angle), np.sin(angle), np.ones(length), np.arange(length)], axis=1)

    def lines(values: Array) -> Complex:
        """Fit sine, level and drift to every stretch; return amplitude and phase of the sine."""
        parts = values[: stretches * length].reshape(stretches, length)
        (cosine, sine, *_), *_ = np.linalg.lstsq(basis, parts.T, rcond=None)
        return np.asarray(cosine - 1j * sine)

    asked, moved = lines(force), lines(position)
    products = moved * asked.conj(), np.abs(asked) ** 2, np.abs(moved) ** 2
    cross, power, size = (np.array([np.mean(each)]) for each in products)
    return _ratio(user, np.array([frequency_hz]), cross, power, size, stretches)


def _ratio(
    user: UserTraces, hertz: Array, cross: Complex, power: Array, moved: Array, stretches: int
) -> Admittance:
    """Return the admittance of the cross spectrum and the power of force and position."""
    least = np.finfo(float).tiny
    coherence = np.minimum(np.abs(cross) ** 2 / np.maximum(power * moved, least), 1.0)
    return Admittance(user.name, hertz, cross / np.maximum(power, least), coherence, stretches)
