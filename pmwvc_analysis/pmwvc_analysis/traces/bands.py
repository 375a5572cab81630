# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The voluntary band: the frequencies at which hands and environments move on purpose.

For a target that rests, hands move below half a hertz; while they close, below 6 Hz over the
duration of the closing in s. Packets and server steps make images of purposeful motion: of motion
at f sampled at f_s and held, one at f_s - f with f/(f_s - f) of its size. The drive of somebody
else's environment is not known: its motion counts as the loop's.
"""

import math

from pmwvc_core.params import OperatorParams
from pmwvc_core.scenario.scenario import Scenario, User

DEFAULT_BAND_HZ = 8.0
REST_BAND_HZ = 0.5
MINIMUM_JERK = 6.0  # a minimum-jerk move of duration D has next to nothing above 6/D
HARMONICS = 3.5  # of a sinusoid that makes and breaks contact


def operator_band_hz(operator: OperatorParams, move_rise_s: float, *, moves: bool) -> float:
    """Return the frequency below which this operator moves on purpose.

    A sinusoid brings harmonics where contact is made and broken. A recorded person moves and
    trembles up to 10 Hz; so does one with a pointer, whose handle is let go and taken.
    """
    if operator.is_hand:
        return max(2.0, MINIMUM_JERK / move_rise_s) if moves else REST_BAND_HZ
    if operator.is_sinusoid:
        return max(REST_BAND_HZ, HARMONICS * operator.frequency_hz)
    if operator.is_chirp:
        return 1.5 * max(operator.frequency_hz, operator.frequency_end_hz)
    if operator.is_remote or operator.is_recorded:
        return 10.0
    return REST_BAND_HZ


def bands(scenario: Scenario, *, closing: bool) -> tuple[float, float]:
    """Return the band of a session [Hz], that of the fastest hand and of the environment, and the
    largest ratio of sampling images to purposeful motion.

    ``closing``: hands close in what is judged.
    """
    moves = scenario.task.moves
    rise = scenario.task.move_rise_s
    band = max(operator_band_hz(user.operator, rise, moves=moves) for user in scenario.users)
    band = max(band, HARMONICS * scenario.environment.drive_hz(scenario.server))
    if closing:
        band = max(band, MINIMUM_JERK / scenario.task.grip_rise_s)
    drives = (user.operator.frequency_hz for user in scenario.users)
    driven = all(user.operator.is_sinusoid for user in scenario.users)
    highest = max(drives) if driven else band
    slowest = max(scenario.server.period_s, *(user.master.frame_s for user in scenario.users))
    return band, highest / max(1.0 / slowest - highest, highest)


def encoder_noise_m_s(user: User | None) -> float:
    """Return twice the RMS of the velocity that an encoder's steps alone make [m/s]: that of the
    difference of two positions, each uniform within a step q, over one tick: q / (tick sqrt 6).
    """
    if user is None or not user.device.differences:
        return 0.0
    return 2.0 * user.device.encoder_step_m / (user.master.tick_s * math.sqrt(6.0))
