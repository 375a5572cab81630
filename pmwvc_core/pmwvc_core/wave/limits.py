# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits of what an end of a link may send: the receiver refuses more.

Whatever is adjustable stays inside its range, so a device renders at most ``FORCE_N`` and moves at
most at ``VELOCITY_M_S`` while it is coupled; u = (F + b xd)/sqrt(2b) then bounds what a master
emits, and a passive server returns no more.
"""

import math

from pmwvc_core.params import SafetyParams, specs
from pmwvc_core.wave.impedance import Impedance, longest_wave, smallest

FORCE_N = float(specs(SafetyParams)["max_force"].high or math.inf)
VELOCITY_M_S = float(specs(SafetyParams)["fault_velocity"].high or math.inf)
DIRECT = 1000.0  # [m/s] up or [N] down: beyond any device, where there are no waves


def largest_wave(impedance: Impedance, *, waves: bool) -> float:
    """Return the longest wave that can be meant [sqrt(W)].

    Parameters
    ----------
    impedance
        Wave impedance of the port [N s/m].
    waves
        Whether the controller has waves; others send velocities, forces, positions.
    """
    return longest_wave(impedance, FORCE_N, VELOCITY_M_S) if waves else DIRECT


def wave_of_speed(impedance: Impedance, velocity: float) -> float:
    """Return a wave that moves an avatar against nothing no faster than that [sqrt(W)]; velocity
    in m/s.
    """
    return velocity * math.sqrt(0.5 * smallest(impedance))
