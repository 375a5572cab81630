# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop of a scenario, ready to be stepped on the identity: of laws, or of objects where
something is no law yet (what other packages bring; a filter bank behind an impedance matrix).
"""

from collections.abc import Sequence
from typing import cast

from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.objects.outside import checked
from pmwvc_core.made.server import are_made
from pmwvc_core.scenario.scenario import Scenario


def loop_of(scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()) -> Hyperperiod:
    """Return the loop of a scenario; see :class:`.loop.Loop` for what is asked.

    Raises
    ------
    NonlinearError
        If something is not linear, or code from outside the library does not declare its state.
    PmwvcError
        If the hyperperiod is too long.
    """
    if are_made(scenario):
        return Hyperperiod(scenario, live=live, weights=weights)
    # The other one has the same members, with signals of its own form.
    return cast(Hyperperiod, checked(scenario, live=live, weights=weights))
