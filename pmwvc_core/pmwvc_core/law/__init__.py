# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The control laws: pure functions ``step(state, input, params) -> (state, output)``.

States, inputs and parameters are NamedTuples of numbers, truth values and tuples of these; a
vector is a tuple with one float per axis. No law keeps anything, knows of ROS, files or clocks, or
asks for the type of what it is given. Energies that a law moves are part of what it returns. The
same source runs live, and compiled in bulk (:mod:`pmwvc_core.compiled`).
"""
