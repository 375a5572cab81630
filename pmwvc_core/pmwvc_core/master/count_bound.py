# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The bound on what a hand gets from the strict channel behind an encoder whose differences are
the velocity.

While the device does not swing about a count its port gives out no more than

    0.1 b q^2/h     (the first counts are answered before the hand has given anything)

and it does not while b h/m <= ``LARGEST_RATIO``, b <= ``LARGEST_IMPEDANCE`` and frames are
``LEAST_FRAME_S`` or longer, with a hand on the device. Neither is proved: both were measured on
random devices, encoders, hands, contacts, links and rates, and tests repeat that. For a device
alone (a force without an arm) no bound is known.

Equations: docs/theory.md 17.22.
"""

from dataclasses import dataclass

from pmwvc_core.params import DeviceParams, MasterParams
from pmwvc_core.wave.impedance import impedance_of, largest

GIVEN = 0.1
LARGEST_RATIO = 0.15
LARGEST_IMPEDANCE = 60.0  # [N s/m]
LEAST_FRAME_S = 0.004
ROUNDING_S = 1e-9
FIRM_N = 3.0  # packets lack energy where one count is a larger force


@dataclass(frozen=True)
class CountBound:
    """See the module."""

    step_m: float  # [m] the count q
    ratio: float  # b h/m
    given_j: float  # [J] 0.1 b q^2/h, where the bound holds
    count_n: float  # [N] force b q/h of one count in a tick
    impedance: float  # [N s/m] b
    largest_impedance: float  # [N s/m] the largest one with which the bound holds
    frame_s: float  # [s] time between two packets

    @property
    def holds(self) -> bool:
        """Whether the bound holds, with a hand on the device."""
        slow = self.frame_s >= LEAST_FRAME_S - ROUNDING_S
        return slow and self.impedance <= self.largest_impedance

    def text(self) -> str:
        """Return count, condition and amount in words."""
        ratio = f"b = {self.impedance:.3g} N s/m, b h/m = {self.ratio:.2g}"
        frame = f"frames of {1e3 * self.frame_s:.3g} ms"
        if self.holds:
            found = (
                f"{ratio} (at most {LARGEST_IMPEDANCE:g} and {LARGEST_RATIO:g}) and {frame} (at "
                f"least {1e3 * LEAST_FRAME_S:g}), so with a hand on the device its port gives "
                f"out at most 0.1 b q^2/h = {1e3 * self.given_j:.2g} mJ more than it took in "
                "(measured, not proved)"
            )
        else:
            found = (
                f"{ratio} (known up to master.impedance = {self.largest_impedance:.3g} N s/m) and "
                f"{frame} (known from {1e3 * LEAST_FRAME_S:g} on), so the device may swing about "
                "a count, and its port may then give out millijoules and more"
            )
        if self.count_n > FIRM_N:
            found += (
                f". One count is b q/h = {self.count_n:.2g} N (above {FIRM_N:g} N): a grip may "
                "lose force"
            )
        return f"velocities are differences of counts of {1e6 * self.step_m:.3g} um: {found}."


def count_bound(master: MasterParams, device: DeviceParams) -> CountBound:
    """Return the bound for a device with an encoder."""
    impedance, step_m = float(largest(impedance_of(master))), float(device.encoder_step_m)
    tick_s, mass = master.tick_s, float(device.mass)
    return CountBound(
        step_m=step_m,
        ratio=impedance * tick_s / mass,
        given_j=GIVEN * impedance * step_m**2 / tick_s,
        count_n=impedance * step_m / tick_s,
        impedance=impedance,
        largest_impedance=min(LARGEST_RATIO * mass / tick_s, LARGEST_IMPEDANCE),
        frame_s=master.frame_s,
    )
