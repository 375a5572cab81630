# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tuning rule of each controller without waves, as a function of device, link and contact.

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

import math
from collections.abc import Mapping
from dataclasses import dataclass

from pmwvc_core.errors import ParameterError
from pmwvc_core.network.effects import longest_s
from pmwvc_core.params import (
    ContactParams,
    DeviceParams,
    LinkParams,
    MasterParams,
    OperatorParams,
    ServerParams,
    Validated,
)
from pmwvc_core.params.baselines import PspmParams, TdpaParams, VirtualCouplingParams

MARGIN = 0.8  # of the stiffness that a rule allows
LATE_MARGIN = 0.95  # of the same for the local damping: 3 N s/m do at 16 ms where this gives 4.7
STOP_RATIO = 0.1  # of the damping that stops the device within a tick
COUPLING_RATIO = 0.5  # of b: damping of the virtual coupling


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


@dataclass(frozen=True)
class Proposal:
    """Parameters by a rule, and by how much its criteria are met (zero or more) [N s/m].

    A criterion is NaN where it is not known whether it is met.
    """

    params: Validated
    criteria: Mapping[str, float]

    @property
    def met(self) -> bool:
        """Tell whether every criterion is known to be met."""
        return all(value >= 0.0 for value in self.criteria.values())


def loop_of(
    *,
    master: MasterParams,
    device: DeviceParams,
    operator: OperatorParams,
    server: ServerParams,
    contact: ContactParams,
    up: LinkParams,
    down: LinkParams,
) -> Loop:
    """Return what the rules have to know of one user.

    A packet is at most a frame (up) or a step (down) older than its delay when it is replaced;
    the longest delay of each link counts (with normal jitter: by one standard deviation), lost
    packets do not.
    """
    hand = operator.grip_damping if operator.is_hand else 0.0
    return Loop(
        mass=device.mass,
        damping=device.damping + hand,
        tick_s=master.tick_s,
        round_trip_s=longest_s(up) + longest_s(down) + master.frame_s + server.period_s,
        contact_stiffness=contact.contact_stiffness,
        contact_damping=contact.contact_damping,
        period_s=server.period_s,
    )


def _require_round_trip(loop: Loop) -> None:
    if math.isnan(loop.round_trip_s):
        raise ParameterError("a link effect's delay is not known: the rule proposes nothing")


def check_virtual_coupling(params: VirtualCouplingParams, loop: Loop) -> Proposal:
    """Return by how much a virtual coupling meets its rules."""
    k, damping, b = params.stiffness, params.damping, loop.damping
    sampled, delayed = 0.5 * k * loop.tick_s, 0.5 * k * loop.round_trip_s
    return Proposal(params, {"colgate": b - sampled - damping, "delay": b + damping - delayed})


def virtual_coupling(loop: Loop) -> Proposal:
    """Return half the damping there is, and the stiffness that the tighter rule then allows;
    ParameterError without any damping at the device, where no stiffness is allowed, and where the
    round trip is not known.
    """
    _require_round_trip(loop)
    if loop.damping <= 0.0:
        raise ParameterError("device.damping = 0, and no hand: a virtual coupling needs damping")
    damping = COUPLING_RATIO * loop.damping
    passive = 2.0 * (loop.damping - damping) / loop.tick_s
    late = 2.0 * (loop.damping + damping) / loop.round_trip_s
    stiffness = MARGIN * min(passive, late)
    return check_virtual_coupling(VirtualCouplingParams(stiffness, damping), loop)


def check_tdpa(params: TdpaParams, loop: Loop) -> Proposal:
    """Return by how much the dampers meet their rules."""
    late = 0.5 * loop.contact_stiffness * loop.round_trip_s
    criteria = {
        "sampling": STOP_RATIO * loop.mass / loop.tick_s - params.damping_max,
        "delay": loop.damping + params.damping - late,
        "contact": loop.contact_damping - 0.5 * loop.contact_stiffness * loop.period_s,
    }
    return Proposal(params, criteria)


def tdpa(loop: Loop) -> Proposal:
    """Return the limit of the controller's damper, and the local damping the contact needs.

    The contact itself is not proposed: its criterion may stay unmet. ParameterError where the
    round trip is not known.
    """
    _require_round_trip(loop)
    late = 0.5 * loop.contact_stiffness * loop.round_trip_s
    params = TdpaParams(
        damping=max(late / LATE_MARGIN - loop.damping, 0.0),
        damping_max=STOP_RATIO * loop.mass / loop.tick_s,
    )
    return check_tdpa(params, loop)


def check_pspm(params: PspmParams, loop: Loop) -> Proposal:
    """Return by how much the damper outweighs the held spring."""
    return Proposal(params, {"sampling": params.damping - 0.5 * params.stiffness * loop.tick_s})


def pspm(loop: Loop) -> Proposal:
    """Return a spring as stiff as the contact, unless the damper does not allow it.

    A stiffer one brings the ends closer together but drags more: it is K (T_1 + T_2) that is felt
    in motion.
    """
    damping = PspmParams().damping
    allowed = MARGIN * 2.0 * damping / loop.tick_s
    stiffness = min(loop.contact_stiffness or allowed, allowed)
    return check_pspm(PspmParams(stiffness=stiffness, damping=damping), loop)
