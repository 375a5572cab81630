# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The status text while a session runs."""

import io
from dataclasses import replace

from rich.console import Console

from pmwvc_bringup.session.terminal import Status, UserStatus

COUPLED = UserStatus(
    "user1",
    tick_hz=1000.4,
    packet_hz=125.0,
    delay_s=0.0161,
    force_n=-1.5,
    state=1,
    contact=True,
)


def test_a_line_tells_all_of_every_user():
    text = Status(2.0, 10.0, [COUPLED, UserStatus("user2")], ["netem was ended by SIGKILL"]).line()
    assert text == (
        "   2.0 / 10 s | user1 1000 Hz 125/s 16.1 ms -1.50 N coupled, contact"
        " | user2 - - - - no data | netem was ended by SIGKILL"
    )


def test_delays_that_the_ends_see_stand_for_both_directions():
    seen = replace(COUPLED, up_s=0.0172, down_s=0.0168)
    assert " 17.2/16.8 ms " in Status(2.0, 10.0, [seen]).line()


def test_a_table_tells_the_same():
    console = Console(file=io.StringIO(), width=120)
    console.print(Status(2.0, 10.0, [COUPLED], ["netem was ended by SIGKILL"]).table())
    text = console.file.getvalue()
    for part in ("user1", "1000 Hz", "125/s", "16.1 ms", "-1.50 N", "SIGKILL"):
        assert part in text
