# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a controller: the laws of both ends, and the properties that other code asks for
by name; and the rules for the parameters of those without waves, by device, link and contact.

In these b is all damping at the device, also the hand's, and T_1 + T_2 the oldest that what comes
back can be; it is not known where the delay of a link's effect is not.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from pmwvc_core.account import Entry
from pmwvc_core.errors import ParameterError
from pmwvc_core.network.effects import longest_s
from pmwvc_core.params import BaselineParams, MasterParams, ServerParams
from pmwvc_core.params.server import PspmParams, TdpaParams, VirtualCouplingParams
from pmwvc_core.plugins import Record
from pmwvc_core.server.couplings import Coupling

STOP_RATIO = 0.1  # of the damping that stops the device within a tick


class Loop(NamedTuple):
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
        tick_s=master.tick_s, round_trip_s=links_s + master.frame_s + period_s,
        contact_stiffness=contact.contact_stiffness, contact_damping=contact.contact_damping,
        period_s=period_s,
    )  # fmt: skip


def check_virtual_coupling(params: VirtualCouplingParams, loop: Loop) -> Margins:
    """Return by how much a virtual coupling meets its rules: b > K_c T_c/2 + B_c, passive without
    delay (Colgate and Schenkel 1997); b + B_c >= K_c (T_1 + T_2)/2, damping outweighs what the
    spring's lag takes away.
    """
    k, damping, b = params.stiffness, params.damping, loop.damping
    sampled, delayed = 0.5 * k * loop.tick_s, 0.5 * k * loop.round_trip_s
    return {"colgate": b - sampled - damping, "delay": b + damping - delayed}


def check_tdpa(params: TdpaParams, loop: Loop) -> Margins:
    """Return by how much the dampers meet their rules: damping_max = m/(10 T_c), a tenth of what
    stops a mass within a tick, as with an encoder the velocity is wrong by d/T_c and a larger
    damper turns that into chatter (ours; Hannaford and Ryu 2002 discuss the limit); b + damping >=
    K (T_1 + T_2)/2 and B >= K h/2, as the contact's force is late, sampled and held, and what that
    makes is not the link's (ours).
    """
    late = 0.5 * loop.contact_stiffness * loop.round_trip_s
    return {
        "sampling": STOP_RATIO * loop.mass / loop.tick_s - params.damping_max,
        "delay": loop.damping + params.damping - late,
        "contact": loop.contact_damping - 0.5 * loop.contact_stiffness * loop.period_s,
    }


def check_pspm(params: PspmParams, loop: Loop) -> Margins:
    """Return by how much the damper outweighs a held spring: B > K T_c/2 (Lee and Huang 2010)."""
    return {"sampling": params.damping - 0.5 * params.stiffness * loop.tick_s}


# The server's end of a controller without waves: the object moves under the forces held.
HELD = Coupling(
    name="held forces",
    words="The object moves under the forces of the step before.",
    moves="backward_euler",
)


@dataclass(frozen=True, kw_only=True)
class Controller(Record):
    """A controller: the laws of its ends, and its properties."""

    # whether packets carry wave variables; otherwise velocity and position up, force or position
    # down, with ``FLAG_DIRECT``
    waves: bool
    # the laws of the ends of one of another package, as :mod:`pmwvc_core.controllers.plugged` has
    # them; None: those of the library (of ``pmwvc``, where packets carry waves)
    device: Callable[[Any, Any, Any], tuple[Any, Any]] | None = None
    avatar: Callable[[Any, Any, Any], tuple[Any, Any]] | None = None
    # of one of the library without waves: from its parameters (in ``baseline.*``) and the tick
    # [s], the NamedTuple by whose type the families of :mod:`pmwvc_core.law.without_waves` choose
    # its laws
    law: Callable[[Any, float], Any] | None = None
    # from the parameters and the number of axes, the states that the ends start from (NamedTuples)
    device_rest: Callable[[Any, int], Any] = lambda p, axes: ()
    avatar_rest: Callable[[Any, int], Any] = lambda p, axes: ()
    # how many ``extra`` signals a packet carries up and down, for a number of axes
    extra: Callable[[int], tuple[int, int]] = lambda axes: (0, 0)
    # dataclass of its own parameters, each a field by :func:`pmwvc_core.params.fields.field`; in a
    # scenario they stand in a group with the controller's name
    params: type | None = None
    # from the state of either law, the accounts that it keeps [J], in the order of ``accounts``
    energies: Callable[[Any], tuple[float, ...]] = lambda s: ()
    # by how much its parameters, in ``baseline.*``, meet its tuning rule; None where it has none
    rule: Callable[[Any, Loop], Margins] | None = None
    # energy that the two ends of a user hold at the start by their parameters [J]
    storage_j: Callable[[MasterParams, BaselineParams], float] = lambda master, baseline: 0.0
    # how its own server end couples avatars and object; None: as ``server.coupling`` (waves only)
    coupling: Coupling | None = None
    # every account that an end may keep; those that no signal shows are remainders: the energy
    # budget closes whatever they are
    accounts: tuple[Entry, ...] = ()

    def __post_init__(self) -> None:
        """Refuse properties that contradict one another."""
        if self.coupling is None and not self.waves:
            raise ParameterError("coupling = None: server.coupling belongs to waves")
        if self.device is not None and self.avatar is None and not self.waves:
            raise ParameterError("avatar = None: a controller without waves needs both laws")

    def check(self, baseline: BaselineParams, loop: Loop) -> Margins:
        """Return by how much parameters meet the tuning rule; nothing without a rule."""
        return self.rule(getattr(baseline, self.name), loop) if self.rule else {}
