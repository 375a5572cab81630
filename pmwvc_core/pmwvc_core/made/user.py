# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's force loop, made from a scenario, and its parameters that change in flight, at a frame
start.

Waves carry the same power whatever the impedance, so that may change at any time, and so may
position feedback, local model, rate drop and deadband. Another filter, hold or velocity filter
starts at zero: what the old one held is lost, never gained. Sums of energy go on.
"""

import dataclasses
from typing import Any

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing, record_of
from pmwvc_core.controllers.plugged import DeviceAnswer, Plugged, PluggedParams
from pmwvc_core.controllers.record import Controller
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.packet import LATENESSES, no_packet, packing_params, resting_packing
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import Nothing
from pmwvc_core.law.port.filter_bank import Bank, changed_local, resting_bank
from pmwvc_core.law.port.master import NEVER_NS
from pmwvc_core.law.port.port_filters import Filtered, FilteredParams
from pmwvc_core.law.port.strict_master import StrictMasterParams
from pmwvc_core.law.safety.brakes import HAND_RETURN_S, brake_stiffness
from pmwvc_core.law.safety.limits import (
    LARGEST,
    REACH,
    LimitsParams,
    limits_params,
    resting_limits,
)
from pmwvc_core.law.user_tick import User, UserParams
from pmwvc_core.law.wave.filter_and_hold import Hold, resting_filter
from pmwvc_core.law.without_waves.ends import DeviceEndParams, resting_end
from pmwvc_core.made.waves import (
    lent_of,
    position_params,
    resting_filters,
    resting_position,
    resting_waves,
    waves_params,
)
from pmwvc_core.params import MasterParams
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import largest_wave, wave_of_speed

NEVER = 1 << 62  # ticks
REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most
# What may change without a new beginning of what is around the port.
GOES_ON = ("impedance", "position", "bank", "local_model", "rate_drop", "deadband")


def values_of(user: "scenarios.User", record: Controller) -> Any:
    """Return a user's parameters of a controller: those of ``baseline.*``, or of another package;
    None without any.
    """
    if record.law is not None:
        return user.baseline
    return getattr(user.own, record.name) if record.params else None


def arrivals_params(
    controller: str, channel: str, b: Any, *, timeout_s: float, lets_go_s: float, store_j: float
) -> ArrivalsParams:
    """Return the rules of a receiver of a port of this impedance [N s/m], whose brake lets go in
    so much time after an outage [s], and whose playout begins with so much energy [J].
    """
    return ArrivalsParams(
        timeout_s,
        float(largest_wave(b, waves=has_waves(controller))),
        is_zeroing(controller, channel),
        is_strict(controller, channel),
        PlayoutParams(float(wave_of_speed(b, REPAID_M_S)), lets_go_s, store_j),
    )


def user_params(
    user: "scenarios.User", *, controller: str, channel: str, packet_s: float, answer_tick: int,
    workspace_m: float | None = None,
) -> UserParams:  # fmt: skip
    """Return the parameters of a user's force loop."""
    master, b, safety, record = user.master, user.impedance, user.safety, record_of(controller)
    strict, tick_s = is_strict(controller, channel), master.tick_s
    arrivals = arrivals_params(
        controller, channel, b,
        timeout_s=safety.timeout_s, lets_go_s=HAND_RETURN_S, store_j=master.store_j,
    )  # fmt: skip
    values = values_of(user, record)
    if record.device is not None:
        port: Any = PluggedParams(record.device, values, record.energies, tick_s, record.waves)
    elif record.law is not None:
        port = DeviceEndParams(tick_s, record.law(values, tick_s))
    else:
        port = waves_params(master, b, arrivals.playout, strict=strict)
    stiffness = brake_stiffness(impedances.smallest(b)) if strict else 0.0
    reach = LARGEST if workspace_m is None else REACH * workspace_m
    limits = limits_params(safety, tick_s, packet_s, reach, stiffness)
    packing = packing_params(master.deadband)
    return UserParams(master.rate_drop, answer_tick, tick_s, packing, arrivals, port, limits)


def resting_user(
    user: "scenarios.User", p: UserParams, *, controller: str, axes: int, packet_s: float
) -> User:
    """Return a user's force loop at rest."""
    nothing, master, record = (0.0,) * axes, user.master, record_of(controller)
    law, packet = record.device_rest(values_of(user, record), axes), no_packet(nothing, ())
    if record.device is not None:
        up, down = record.extra(axes)
        answer = DeviceAnswer(nothing, nothing, (0.0,) * up)
        came, sums_j = packet._replace(extra=(0.0,) * down), (0.0,) * 4
        port: Any = Plugged(law, nothing, nothing, came, False, False, answer, nothing, *sums_j)
    elif record.law is not None:
        port = resting_end(law, axes)
    else:
        port = resting_waves(master, p.port, axes)
    arrivals = start_of(p.arrivals.plays_on, axes, user.safety.timeout_s, packet_s)
    return User(
        0, 0, master.rate_drop, master.frame_s, resting_packing(axes), arrivals, packet, 0, port,
        resting_limits(nothing, p.limits), nothing, NEVER_NS, 0, NEVER, False,
    )  # fmt: skip


def changed_master(
    s: User, p: UserParams, q: UserParams, old: MasterParams, new: MasterParams
) -> tuple[User, UserParams]:
    """Take other parameters of a master over: ``p`` are those of the force loop as it runs, ``q``
    as it would be made now.
    """
    port, was, wanted = s.port, p.port, q.port
    if hasattr(wanted, "filters"):
        kept = {name: getattr(old, name) for name in GOES_ON}
        anew = dataclasses.replace(new, **kept) != old
        rest, strict = (0.0,) * len(port.x), isinstance(wanted, StrictMasterParams)
        filters, of_filters = _filters(port.filters, was.filters, wanted.filters, new, anew=anew)
        position, of_position = port.position, wanted.position
        if isinstance(position, Nothing):
            position = resting_position(new, of_position, rest, strict=strict)
        else:
            of_position = position_params(new, wanted.impedance, strict=strict)
        port = port._replace(filters=filters, position=position)
        wanted = wanted._replace(filters=of_filters, position=of_position)
        if strict:
            lends, lent_j = not isinstance(position, Nothing), lent_of(of_position)
            wanted = wanted._replace(lends=lends, lent_j=lent_j)
        elif anew:
            chosen = resting_filter(new.filter, len(rest), wanted.filter)
            port = port._replace(hold=Hold(rest, rest, rest, 0), filter=chosen)
        else:
            held = {"hold_ticks": was.hold_ticks, "frame_s": was.frame_s}
            wanted = wanted._replace(filter=was.filter, **held)
    q = q._replace(port=wanted, limits=_limits(p, q), arrivals=p.arrivals)
    return s._replace(port=port), q


def _filters(s: Any, p: Any, q: Any, new: MasterParams, *, anew: bool) -> tuple[Any, Any]:
    """Return the filters of a port and their parameters; which there are never changes."""
    if not isinstance(q, FilteredParams):
        return s, q
    if not anew:
        q = q._replace(near=p.near, force=p.force)
    rest = resting_filters(new, q, len(s.held))
    assert isinstance(rest, Filtered)
    near, far, force = s.near, s.far, s.force
    if anew:
        near, force = (  # at rest, but they go on counting
            each._replace(kept_j=old.kept_j) if hasattr(each, "kept_j") else each
            for each, old in ((rest.near, near), (rest.force, force))
        )
    if isinstance(far, Bank):
        local = changed_local(far.local, p.far.local, q.far.local)
        if q.far[:4] != p.far[:4]:  # another split starts at zero
            far = resting_bank(len(far.low_up), q.far)._replace(energies=far.energies)
        far = far._replace(local=local)
    return Filtered(near, far, force, s.held, s.gains), q


def _limits(p: UserParams, q: UserParams) -> LimitsParams:
    """Return other limits; a brake that holds keeps its stiffness, a receiver what it was made
    for.
    """
    return q.limits._replace(brakes=p.limits.brakes, brake_stiffness=p.limits.brake_stiffness)


def changed_safety(s: User, p: UserParams, q: UserParams) -> tuple[User, UserParams]:
    """Take other limits over, and another time of silence; ``q`` is the force loop as it would be
    made now.
    """
    silence, timeout_s = s.arrivals.silence, q.arrivals.timeout_s
    of_packets_s = 3.0 * silence.interval_s + LATENESSES * silence.lateness_s
    silence = silence._replace(limit_ns=round(max(timeout_s, of_packets_s) * 1e9))
    arrivals = p.arrivals._replace(timeout_s=timeout_s)
    s = s._replace(arrivals=s.arrivals._replace(silence=silence))
    return s, p._replace(limits=_limits(p, q), arrivals=arrivals)
