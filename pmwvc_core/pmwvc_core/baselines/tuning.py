# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rules for the parameters of controllers without waves, by device, link and contact.

==============================  ================================================================
b > K_c T_c/2 + B_c             virtual coupling without delay: passive (Colgate and Schenkel
                                1997)
b + B_c >= K_c (T_1 + T_2)/2    with delay: damping outweighs what the spring's lag takes away
damping_max = m/(10 T_c)        a tenth of what stops a mass m within a tick: with an encoder the
                                velocity is wrong by d/T_c, and a larger damper turns that into
                                chatter (ours; Hannaford and Ryu 2002 discuss the limit)
b + damping >= K (T_1 + T_2)/2  time-domain passivity: the same for the contact, whose force is
                                what is late; without it a passive link may oscillate (ours)
B >= K h/2                      likewise: its contact is sampled and held over a step h, and what
                                that makes is not the link's (as with direct coupling)
B > K T_c/2                     set-position modulation (Lee and Huang 2010)
==============================  ================================================================

b is all damping at the device, also the hand's; T_1 + T_2 the oldest that what comes back can be.
Where an effect of the link has a delay that is not known, so is what a rule with T_1 + T_2 says.
Not here: waves, whose rules are in docs/theory.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from pmwvc_core.network.effects import longest_s
from pmwvc_core.params import ServerParams
from pmwvc_core.params.baselines import PspmParams, TdpaParams, VirtualCouplingParams

STOP_RATIO = 0.1  # of the damping that stops the device within a tick


@dataclass(frozen=True)
class Loop:
    """The data of the loop that a tuning rule uses."""

    mass: float  # [kg] of the device
    damping: float  # [N s/m] b, device and hand
    tick_s: float  # T_c
    round_trip_s: float  # T_1 + T_2; NaN: not known
    contact_stiffness: float  # [N/m] K
    contact_damping: float  # [N s/m] B
    period_s: float  # h, step of the server


# By how much each criterion of a rule is met (zero or more) [N s/m]; NaN: not known.
Margins: TypeAlias = Mapping[str, float]


def loop_of(user: Any, server: ServerParams) -> Loop:
    """Return what the rules have to know of one user of a scenario.

    A packet is at most a frame (up) or a step (down) older than its delay when it is replaced;
    the longest delay of each link counts (with normal jitter: by one standard deviation), lost
    packets do not.
    """
    master, hand, contact, period_s = user.master, user.operator, user.contact, server.period_s
    links_s = longest_s(user.link_up) + longest_s(user.link_down)
    return Loop(
        mass=user.device.mass,
        damping=user.device.damping + (hand.grip_damping if hand.is_hand else 0.0),
        tick_s=master.tick_s,
        round_trip_s=links_s + master.frame_s + period_s,
        contact_stiffness=contact.contact_stiffness,
        contact_damping=contact.contact_damping,
        period_s=period_s,
    )


def check_virtual_coupling(params: VirtualCouplingParams, loop: Loop) -> Margins:
    """Return by how much a virtual coupling meets its rules."""
    k, damping, b = params.stiffness, params.damping, loop.damping
    sampled, delayed = 0.5 * k * loop.tick_s, 0.5 * k * loop.round_trip_s
    return {"colgate": b - sampled - damping, "delay": b + damping - delayed}


def check_tdpa(params: TdpaParams, loop: Loop) -> Margins:
    """Return by how much the dampers meet their rules."""
    late = 0.5 * loop.contact_stiffness * loop.round_trip_s
    return {
        "sampling": STOP_RATIO * loop.mass / loop.tick_s - params.damping_max,
        "delay": loop.damping + params.damping - late,
        "contact": loop.contact_damping - 0.5 * loop.contact_stiffness * loop.period_s,
    }


def check_pspm(params: PspmParams, loop: Loop) -> Margins:
    """Return by how much the damper outweighs the held spring."""
    return {"sampling": params.damping - 0.5 * params.stiffness * loop.tick_s}
