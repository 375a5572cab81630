# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of a link's delay, a little at a time.

A delay that grows at once leaves a gap as long as its growth; beyond the watchdog's patience both
hands would be dropped.
"""

from dataclasses import replace

from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario

RATE = 0.5  # s of delay per s


def ramped(present: Scenario, wanted: Scenario, *, over_s: float) -> Scenario:
    """Return the scenario wanted, with delays as far from the present ones as may be after so
    long [s]. Other settings of a link change once its delay is there.
    """
    users = tuple(
        replace(
            new,
            link_up=towards(old.link_up, new.link_up, over_s=over_s),
            link_down=towards(old.link_down, new.link_down, over_s=over_s),
        )
        for old, new in zip(present.users, wanted.users, strict=True)
    )
    return replace(wanted, users=users)


def towards(present: LinkParams, wanted: LinkParams, *, over_s: float) -> LinkParams:
    """Return the settings of one link after so long [s]."""
    if present == wanted:
        return present
    most = RATE * over_s
    step = wanted.delay_s - present.delay_s
    if abs(step) <= most:
        return wanted
    return replace(present, delay_s=present.delay_s + (most if step > 0.0 else -most))
