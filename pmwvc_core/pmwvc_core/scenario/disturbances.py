# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The disturbances of a live session: nodes that are killed, started, stopped or continued.

``6 kill server; 7 start server``: at a time [s] from the start of the session, an action and the
node: server, netem, recorder, or a user for its master.
"""

import math
import re
from typing import NamedTuple

from pmwvc_core.errors import ParameterError

ACTIONS = ("kill", "start", "stop", "continue")
SHARED = ("server", "netem", "recorder")
USER = re.compile("user[1-9][0-9]*")


class Disturbance(NamedTuple):
    """One of them."""

    time_s: float
    action: str
    node: str

    def __str__(self) -> str:
        """Return it in words."""
        return f"{self.action} {self.node} at {self.time_s:g} s"


def disturbances_of(text: str) -> tuple[Disturbance, ...]:
    """Read the disturbances of a scenario; ParameterError names entry, value and range."""
    found: list[Disturbance] = []
    for number, part in enumerate(filter(str.strip, text.split(";")), start=1):
        where = f"disturbances: entry {number} {part.strip()!r}"
        words = part.split()
        if len(words) != 3 or words[1] not in ACTIONS:
            raise ParameterError(f"{where}: must be TIME ACTION NODE, {' or '.join(ACTIONS)}")
        if words[2] not in SHARED and not USER.fullmatch(words[2]):
            raise ParameterError(
                f"{where}: {words[2]!r}: must be {', '.join(SHARED)} or a user, user1"
            )
        try:
            time_s = float(words[0])
        except ValueError:
            time_s = math.nan
        least_s = found[-1].time_s if found else 0.0
        if not least_s <= time_s <= 86400.0:
            raise ParameterError(
                f"{where}: time = {words[0]}: must be {least_s:g}..86400 s; entries come in the "
                "order of their times"
            )
        found.append(Disturbance(time_s, words[1], words[2]))
    return tuple(found)
