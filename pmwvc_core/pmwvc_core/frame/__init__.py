# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame protocol, free of I/O, threads and clocks: one object per end, stepped from outside.

::

    frame start   a master sends its filter's output of the last tick     ForceLoop.start_frame
    server phase  the server takes in what has arrived, steps, answers    ServerStep.tick
    answer phase  a master gives the newest answer to its controller      ForceLoop.tick
    every tick    device -> controller -> safety limits -> device         ForceLoop.tick

The live nodes and the simulator drive the same two objects; :mod:`.schedule` has the phases,
:mod:`.assembly` makes either end from parameters or from a scenario.
"""
