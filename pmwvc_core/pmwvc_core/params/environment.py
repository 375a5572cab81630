# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of environments of the library; stiffness, damping and gap are the contact's."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter


@dataclass(frozen=True)
class HuntCrossleyParams(Validated):
    """Nonlinear contact, F = K d^n (1 + c d') with K = contact_stiffness in N/m^n."""

    exponent: float = parameter(
        1.5, "-", "n (Hertz, two spheres: 1.5)", low=1.0, high=3.0, read_only=True
    )
    damping: float = parameter(
        0.5, "s/m", "c, damping per elastic force and speed", low=0.0, read_only=True
    )


@dataclass(frozen=True)
class ActiveWallParams(Validated):
    """A wall driven along axis 0, x = A sin(2 pi f t) from the first user on."""

    amplitude_m: float = parameter(
        0.01, "m", "amplitude A of the motion", low=0.0, high=0.1, read_only=True
    )
    frequency_hz: float = parameter(
        0.5, "Hz", "frequency f of the motion", low=0.0, high=10.0, read_only=True
    )
