# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's force loop, made from a scenario, at rest, and its parameters that change in flight, at
a frame start: at any time, as waves carry the same power whatever the impedance. Filters stay, and
sums of energy go on.
"""

import math
from typing import Any

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing, record_of
from pmwvc_core.controllers.plugged import DeviceAnswer, Plugged, PluggedLaw
from pmwvc_core.controllers.record import Controller
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.constants import STALL_S, TANK_J
from pmwvc_core.law.channel.packet import LATENESSES, Deadband, Packing, no_packet
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import Nothing
from pmwvc_core.law.port.filter_bank import Bank, changed_local
from pmwvc_core.law.port.port_filters import FilteredParams
from pmwvc_core.law.port.strict_master import StrictMasterParams
from pmwvc_core.law.safety.brakes import HAND_RETURN_S, loose_brake
from pmwvc_core.law.safety.limits import Limits, LimitsParams, Part
from pmwvc_core.law.user_tick import NEVER_NS, ForceLoop, UserParams
from pmwvc_core.law.vectors import Vector
from pmwvc_core.law.without_waves.ends import DeviceEnd, DeviceEndParams
from pmwvc_core.made.waves import made_waves, position_params
from pmwvc_core.numeric import AXES
from pmwvc_core.params import DeadbandParams, MasterParams, SafetyParams
from pmwvc_core.params.behind import strictest
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import largest_wave

NEVER = 1 << 62  # ticks
ROUNDING = 1e-9  # of times, relative
REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most


def groups_of(axes: int) -> tuple[Vector, ...]:
    """Return the axes of what is limited and braked together: of six force and torque apart."""
    apart = (1.0,) * 3 + (0.0,) * 3, (0.0,) * 3 + (1.0,) * 3
    return apart if axes == AXES else ((1.0,) * axes,)


def values_of(user: "scenarios.User", record: Controller) -> Any:
    """Return a user's parameters of a controller, in ``baseline.*`` or its own group, or None."""
    return getattr(user.own if record.params else user.baseline, record.name, None)


def end_law(record: Controller, values: Any, tick_s: float) -> Any:
    """Return what chooses the law of an end without waves, or of another package."""
    if record.law is not None:
        return record.law(values, tick_s)
    device: Any = record.device
    return PluggedLaw(device, record.avatar, values, record.energies, record.waves)


def packing_params(deadband: DeadbandParams) -> Deadband:
    """Return the parameters of a sender."""
    ratio = deadband.ratio if deadband.is_on else -1.0
    return Deadband(float(ratio), deadband.longest_s * (1.0 + ROUNDING))


def limits_params(
    safety: SafetyParams, tick_s: float, packet_s: float, brake: float, groups: Any
) -> LimitsParams:
    """Return the limits of a force loop; a brake of no stiffness is none."""
    return LimitsParams(
        safety.max_force, safety.max_slew * tick_s, safety.damper_velocity, safety.fault_velocity,
        max(safety.timeout_s, 3.0 * packet_s), safety.release_s, safety.soft_start_s, tick_s,
        brake > 0.0, brake, groups,
    )  # fmt: skip


def arrivals_params(
    session: Any, b: Any, timeout_s: float, lets_go_s: float, store_j: float
) -> ArrivalsParams:
    """Return the rules of a receiver of a port of this impedance [N s/m], whose brake lets go in
    so much time after an outage [s], and whose playout begins with so much energy [J].
    """
    repaid = REPAID_M_S * math.sqrt(0.5 * impedances.smallest(b))  # moves a free avatar so fast
    return ArrivalsParams(
        timeout_s,
        float(largest_wave(b, waves=has_waves(session.controller))),
        is_zeroing(session.controller, session.channel),
        is_strict(session.controller, session.channel),
        PlayoutParams(repaid, lets_go_s, store_j, TANK_J - store_j),
    )


def made_user(
    user: "scenarios.User", session: Any, *, answer_tick: int = 0
) -> tuple[ForceLoop, UserParams]:
    """Return a user's force loop at rest, and its parameters; ``session`` has controller, channel,
    axes and server (a scenario, or what a node was given).
    """
    master, b, safety, axes = user.master, user.impedance, user.safety, session.dof
    safety = strictest(safety, user.given_safety) if axes == AXES else safety  # turns: as given
    record, strict = record_of(session.controller), is_strict(session.controller, session.channel)
    packet_s, tick_s = session.server.period_s, master.tick_s
    of_arrivals = arrivals_params(session, b, safety.timeout_s, HAND_RETURN_S, master.store_j)
    nothing, values = (0.0,) * axes, values_of(user, record)
    packet, law = no_packet(nothing, ()), record.device_rest(values, axes)
    port: Any
    of_port: Any
    if record.device is not None or record.law is not None:
        if record.device is not None:
            up, down = record.extra(axes)
            answer = DeviceAnswer(nothing, nothing, (0.0,) * up)
            law = Plugged(law, packet._replace(extra=(0.0,) * down), answer)
        port = DeviceEnd(nothing, nothing, nothing, law)
        of_port = DeviceEndParams(tick_s, end_law(record, values, tick_s))
    else:
        port, of_port = made_waves(master, b, axes, of_arrivals.playout, strict=strict)
    stiffness = impedances.smallest(b) * (1.0 / STALL_S) if strict else 0.0
    lever_m = session.server.lever_m
    shares = 1.0, safety.torque_n_m(lever_m) / (safety.max_force * lever_m)
    groups = tuple(zip(groups_of(axes), shares, strict=False))
    of_limits = limits_params(safety, tick_s, packet_s, stiffness, groups)
    arrivals = start_of(of_arrivals.plays_on, axes, safety.timeout_s, packet_s)
    parts = (Part(loose_brake(nothing)),) * len(groups)
    limits = Limits(nothing, nothing, parts, of_limits.timeout_s)
    s = ForceLoop(
        0, 0, master.rate_drop, master.frame_s, Packing(*(nothing,) * 3), arrivals, packet, 0,
        port, limits, nothing, NEVER_NS, 0, NEVER, False,
    )  # fmt: skip
    packing = packing_params(master.deadband)
    return s, UserParams(
        master.rate_drop, answer_tick, tick_s, packing, of_arrivals, of_port, of_limits
    )


def changed_user(
    s: ForceLoop, p: UserParams, made: tuple[ForceLoop, UserParams], old: "scenarios.User",
    new: "scenarios.User",
) -> tuple[ForceLoop, UserParams]:  # fmt: skip
    """Take other parameters of master and limits over: ``s`` and ``p`` are the force loop as it
    runs, ``made`` as it would begin now. A brake that holds keeps its stiffness, a receiver what
    it was made for, but for the time of silence.
    """
    (rest, q), port, of_port, arrivals = made, s.port, p.port, s.arrivals
    if new.master is not old.master:
        port, of_port = _changed_port(port, of_port, rest.port, q.port, new.master)
    timeout_s = q.arrivals.timeout_s
    if new.given_safety is not old.given_safety:
        silence = arrivals.silence
        of_packets_s = 3.0 * silence.interval_s + LATENESSES * silence.lateness_s
        silence = silence._replace(limit_ns=round(max(timeout_s, of_packets_s) * 1e9))
        arrivals = arrivals._replace(silence=silence)
    of_limits = q.limits._replace(brakes=p.limits.brakes, brake_stiffness=p.limits.brake_stiffness)
    of_arrivals = p.arrivals._replace(timeout_s=timeout_s)
    q = q._replace(port=of_port, limits=of_limits, arrivals=of_arrivals)
    return s._replace(port=port, arrivals=arrivals), q


def _changed_port(
    port: Any, was: Any, rest: Any, wanted: Any, new: MasterParams
) -> tuple[Any, Any]:
    """Return a port that goes on with other parameters of its master, and its parameters."""
    if not hasattr(wanted, "filters"):
        return port, wanted
    if isinstance(wanted.filters, FilteredParams):  # designed for the rate drop of the start
        filters, q = port.filters, wanted.filters._replace(near=was.filters.near)
        if isinstance(far := filters.far, Bank):
            local = changed_local(far.local, was.filters.far.local, q.far.local)
            filters = filters._replace(far=far._replace(local=local))
        port, wanted = port._replace(filters=filters), wanted._replace(filters=q)
    strict = isinstance(wanted, StrictMasterParams)
    if isinstance(port.position, Nothing):
        port = port._replace(position=rest.position)
    else:
        of_position = position_params(new, wanted.impedance, strict=strict)
        wanted = wanted._replace(position=of_position)
    if strict:
        lends = not isinstance(port.position, Nothing)
        lent_j = wanted.position.lent_j if lends else 0.0
        wanted = wanted._replace(lends=lends, lent_j=lent_j)
    return port, wanted
