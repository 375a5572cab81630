# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An avatar as a coupling sees it, and the family of couplings.

A coupling closes the algebraic loop of a step: from the waves u of all avatars it finds velocities
and contact forces, and moves avatars and object. Avatars that are not present take no part.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.server.contacts import Contact
from pmwvc_core.law.vectors import Vector

couple = Family("couple")  # (p, avatars, body, law) -> (avatars, body, lost_j, settled)


class Avatar(NamedTuple):
    """One avatar: its port, signals of the last step, contact."""

    present: bool
    impedance: Any  # of the wave port; behind its brake while that acts
    u: Vector  # [sqrt(W)] of this step
    xd: Vector  # [m/s]
    f: Vector  # [N] on the object
    contact: Contact
    kept: Vector  # what a coupling keeps for its next step
