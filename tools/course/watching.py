# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of the steps on the live page, by name of the step."""

from course.first_half import HUM
from course.page import Watched
from course.second_half import STIFF
from course.step import PLAIN, Run

BARE = {**HUM, "master.filter.kind": "none"}
LATE = {**PLAIN, "server.coupling": "one_frame_late", "server.contact_stiffness": STIFF}
LOOK_S = 5.0  # where nothing grows slowly

WATCHED = {
    "01_direct_coupling": Watched(Run("direct_16ms"), {"link.delay_s": 0.0}, "bad", "bad"),
    "02_waves": Watched(Run("direct_16ms", PLAIN), {"controller": "pmwvc"}, "bad", "good"),
    "03_the_price": Watched(Run("wall", PLAIN, LOOK_S), {"link.delay_s": 0.032}, again=True),
    "04_aliasing": Watched(Run("wall", BARE, LOOK_S), before="bad"),
    "05_passivity_adds_up": Watched(
        Run("three_users", PLAIN, LOOK_S), {"server.object_mass": 0.5}
    ),
    "06_late_springs": Watched(
        Run("wall", LATE, 3.4), {"server.contact_stiffness": 500.0}, before="bad"
    ),
    "07_loss": Watched(Run("carry_16ms", PLAIN), {"link.loss": 0.3}, "good", "bad"),
    "08_felt_stiffness": Watched(Run("wall", PLAIN, LOOK_S), {"server.contact_stiffness": 3000.0}),
    "09_choosing_b": Watched(Run("wall", PLAIN, LOOK_S), {"master.impedance": 100.0}),
    "10_what_remains": Watched(Run("three_users", PLAIN), {"link.delay_s": 0.1}, "good", "bad"),
}
