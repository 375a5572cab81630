# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every number by which a session is judged, with its reason. No other module of the
judge has one.

Units are in the names; a number without a unit is a ratio, a count, or a multiple.
"""

# Stability: which motion is an oscillation.
OSCILLATION_M_S = 1e-3  # rms beyond the voluntary band: less is noise of a velocity
WINDOW_S = 0.25  # of one rms value: longer than a hand's step, shorter than any trend
LEAST_WINDOWS = 6  # two for each third of what is judged
SHORTEST_S = LEAST_WINDOWS * WINDOW_S  # less tells no growth from no decay
SETTLE_S = 1.0  # after a contact or a change: transients of a stable loop have died out
HALVED = 0.5  # last third over first: less dies out
FADED = 0.9  # last third over first: more is kept up, what lies between is not known
CHATTER = 4  # changes of contact in half a session: more are the loop's own motion
LEAVING_S = 0.2  # within which users leave together, and the server sees one leave
GROWN_M_S, GROWN = 50e-3, 2.0  # rms at the end, last third over first: an oscillation that grows
GROWS_PER_S = 0.1  # of the exact model: rigid motions have less by rounding
NEUTRAL_PER_S = 1e-6  # in which one that decays by less does not
DEFAULT_WORKSPACE_M, WORKSPACES = 0.2, 1.5  # where none is known; where a position is lost
# Stability: who drives it.
DRIVES = 0.1  # share of the work to and fro by which one side gives: less may be rounding
CYCLES = 4  # a loop that drives gives so many times what masses and springs hold; passive: 2.3
# The voluntary band.
DEFAULT_BAND_HZ = 8.0  # of a person of whom nothing is known
REST_BAND_HZ = 0.5  # of a hand that holds still
RECORDED_HZ = 10.0  # of a recorded person, who trembles as well
MINIMUM_JERK = 6.0  # a minimum-jerk move of duration D has next to nothing above 6/D
HARMONICS = 3.5  # of a sinusoid that makes and breaks contact
# Late packets.
LATE = 0.5  # of the time that a packet stands for: less is jitter of the loops
UNEVEN = 0.01  # of the time spent waiting for late packets: more moves a device
GONE_S = 1.0  # of silence at the end, after which nobody waits for a link
# Passivity.
TOLERANCE_J, TOLERANCE_RELATIVE = 1e-6, 1e-6  # rounding of sums of 1e6 ticks; of energy moved
CLOSED, CLOSED_NOTED = 1e-9, 2e-2  # of the energy moved: rounding; with gaps that are noted
SMALLEST_J = 1e-12  # residual that always closes
# What a hand feels.
STEP_S = 1e-3  # over which a change of force is felt as one
BLOW_N = 0.3  # a fifth of a grip of 1.6 N: twice to three times what fingers can tell apart
BUZZ_HZ = 60.0  # skin feels vibration from here on; hands move and tremble below 10 Hz
IMPACT_S = 0.5  # the longest way of an impact back to the hand, and its bounces
TOUCH_N = 0.02  # from which on an avatar without contacts touches
BACK_S = 1.0  # to be coupled again after what the scenario takes away
BREAK_S = 0.1  # without force or coupling: as long as a grip takes to react to a load
SKIPPED = 0.01  # of the ticks: a loop that skips more does not hold its rate
LEAST_COUPLED = 0.5  # of the time, or the session shows little of the coupling
# Limits that took over.
LIMITED = {"N": 5e-3, "N m": 5e-5}  # by which a force or torque differs that was limited
LIMITED_RATIO = 0.01  # and of its size
OFTEN, OFTEN_RATIO = 3, 0.05  # times, and of the second half: limits that act again and again
LARGEST = 0.99  # of the largest force: as large as the limits allow
WITHHELD_J = 1e-9  # less of a returning wave was not shortened
LOST_M = 2e-3  # less is no loss of an environment
LOST_SHARE = 0.5  # of a device's way: more of it is not the environment's
# Grips.
SLIDES_M_S = 5e-3  # between a part and what it holds: solvers of contacts creep at less
SLIPS_M = 2e-3  # in one go: less is no slip, and no fall
# Nodes.
EARLY_S = 0.5  # before the end of the session: a node that ended then ended early
STALL_S, STALL_PERIODS = 0.02, 2.5  # a pause of a loop: an event, and no filter goes across it
JOIN_S = 0.25  # between two limits of a force that are one event
DEBOUNCE_S = 0.05  # contact that is lost for less was not lost
FINAL_S = 0.5  # of a session: over which values at its end are means
END_S = 0.1  # before the end, when everybody leaves
# Predictions.
LEAST_FORCE_N = 0.2  # less is not the force of a grip
SAME_FORCE = 0.1  # of the larger one: forces of device and avatar in a press at rest
OFFSET_M, OFFSET_RATIO = 0.3e-3, 0.15  # tolerance of an offset: of its own, and of its size
