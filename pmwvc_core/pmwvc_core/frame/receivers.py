# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver of a port, by controller and channel, with the same rules live and simulated.

The channel is chosen here: on the strict one a receiver plays out what arrives, on the zeroing one
it lets a wave count once, on the plain one it holds the newest.
"""

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing
from pmwvc_core.numeric import Value
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.strict_receiver import StrictReceiver
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.limits import largest_wave, wave_of_speed

REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most


def make_receiver(
    controller: str,
    channel: str,
    dof: int,
    impedance: Impedance,
    *,
    period_s: float,
    timeout_s: float,
    lets_go_s: float,
    store_j: Value,
) -> Receiver:
    """Return the receiver of a port, whose brake lets go in so much time after an outage [s], and
    whose playout begins with so much stored energy [J].
    """
    longest = largest_wave(impedance, waves=has_waves(controller))
    if not is_strict(controller, channel):
        return Receiver(
            dof,
            period_s=period_s,
            timeout_s=timeout_s,
            max_wave=longest,
            once=is_zeroing(controller, channel),
        )
    return StrictReceiver(
        dof,
        most_repaid=wave_of_speed(impedance, REPAID_M_S),
        rises_s=lets_go_s,
        store_j=store_j,
        period_s=period_s,
        timeout_s=timeout_s,
        max_wave=longest,
    )
