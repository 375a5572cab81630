# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The status text while a session runs."""

import io
from dataclasses import replace

from rich.console import Console

from pmwvc_bringup.session.terminal import UserStatus, status_line, status_table

TIMES = {"elapsed_s": 2.0, "duration_s": 10.0}
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
    users = [COUPLED, UserStatus("user2")]
    text = status_line(users, ["netem was ended by SIGKILL"], **TIMES)
    assert text == (
        "   2.0 / 10 s | user1 1000 Hz 125/s 16.1 ms -1.50 N coupled, contact"
        " | user2 - - - - no data | netem was ended by SIGKILL"
    )


def test_delays_that_the_ends_see_stand_for_both_directions():
    seen = replace(COUPLED, up_s=0.0172, down_s=0.0168)
    assert " 17.2/16.8 ms " in status_line([seen], [], **TIMES)


def test_a_table_tells_the_same():
    console = Console(file=io.StringIO(), width=120)
    console.print(status_table([COUPLED], ["netem was ended by SIGKILL"], **TIMES))
    text = console.file.getvalue()
    for part in ("user1", "1000 Hz", "125/s", "16.1 ms", "-1.50 N", "SIGKILL"):
        assert part in text
