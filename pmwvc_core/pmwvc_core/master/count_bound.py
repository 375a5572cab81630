# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The bound on what a hand gets from the strict channel behind an encoder whose differences are
the velocity.

While the device does not swing about a count its port gives out no more than

    0.1 b q^2/h     (the first counts are answered before the hand has given anything)

and it does not while b h/m <= ``LARGEST_RATIO``, b <= ``LARGEST_IMPEDANCE`` and frames are
``LEAST_FRAME_S`` or longer, with a hand on the device. Neither is proved: both were measured on
random devices, encoders, hands, contacts, links and rates, and tests repeat that. For a device
alone (a force without an arm) no bound is known. Equations: docs/theory.md 17.22.
"""

from typing import NamedTuple

from pmwvc_core.params import DeviceParams, MasterParams
from pmwvc_core.wave.impedance import impedance_of, largest

GIVEN = 0.1
LARGEST_RATIO = 0.15
LARGEST_IMPEDANCE = 60.0  # [N s/m]
LEAST_FRAME_S = 0.004
ROUNDING_S = 1e-9


class CountBound(NamedTuple):
    """See the module."""

    step_m: float  # [m] the count q
    given_j: float  # [J] 0.1 b q^2/h, where the bound holds
    largest_impedance: float  # [N s/m] the largest one with which the bound holds
    holds: bool  # with a hand on the device
    text: str  # count, condition and amount in words


def count_bound(master: MasterParams, device: DeviceParams) -> CountBound:
    """Return the bound for a device with an encoder."""
    b = master.rises * float(largest(impedance_of(master)))
    q, h, frame_s = float(device.encoder_step_m), master.tick_s, master.frame_s
    given_j, most = GIVEN * b * q**2 / h, min(LARGEST_RATIO * device.mass / h, LARGEST_IMPEDANCE)
    holds = frame_s >= LEAST_FRAME_S - ROUNDING_S and b <= most
    text = f"velocities are differences of counts of {1e6 * q:.3g} um: b = {b:.3g} N s/m, "
    text += f"b h/m = {b * h / device.mass:.2g} and frames of {1e3 * frame_s:.3g} ms. "
    if holds:
        text += "With a hand on the device its port gives out at most 0.1 b q^2/h = "
        text += f"{1e3 * given_j:.2g} mJ more than it took in (measured, not proved)."
    else:
        text += "The device may swing about a count, and its port give out millijoules and more: "
        text += f"a bound is known up to master.impedance = {most:.3g} N s/m, for frames of at "
        text += f"least {1e3 * LEAST_FRAME_S:g} ms."
    return CountBound(q, given_j, most, holds, text)
