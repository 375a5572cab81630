# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The constants of the strict channel: playout, lag and brakes. Nothing else there is tuned.

Tried over losses of 5 to 20 %, bursts, jitter and outages with recorded and simulated hands.
"""

HOLD_S = 0.08  # a late wave is predicted in full: ten packets at 125 Hz
FADE_S = 0.04  # then for so long it fades, while the brakes grow as quickly
MEND_S = 0.03  # a wrong prediction is made good: longer than a packet, shorter than one feels
FOLLOW_S = 0.4  # the lag follows the mean lateness of packets: some fifty of them
CORRECTED = 0.3  # most by which the playout runs faster or slower: it does not sound in the hand
SETTLE_S = 0.1  # after an outage: hands and avatars come to rest before anything is caught up
SLOWLY_S = 0.7  # undelivered displacement is repaid at the slowest, where energy permits
LONGEST_S = 0.3  # in store: more waves than that are of a time that nobody feels any more
FEW = 5e-4  # [sqrt(W) s] undelivered (0.1 mm): nobody is asked for energy
TANK_J = 2.5e-3  # lent or filled by the hand, never spent on repayment: a wave of 1.6 N for 0.1 s
MOST_J = 0.05  # free energy kept where nothing is undelivered: more has no use there
RATIO = 1.3  # of the force before the outage: the brakes yield to a firmer push
STALL_S = 0.0125  # stiffness b/STALL_S of the hand's brake: loops may stall for twice that

OUTAGE_S = HOLD_S + 0.5 * FADE_S  # without waves: this end brakes
REPORTED_S = HOLD_S - 0.5 * FADE_S  # the other end is told, and brakes as late
