# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's force loop, made from a scenario."""

from typing import Any

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing, record_of
from pmwvc_core.controllers.plugged import DeviceAnswer
from pmwvc_core.controllers.plugged_ends import Plugged, PluggedParams
from pmwvc_core.controllers.record import Controller
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.packet import no_packet, packing_params, resting_packing
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.port.sensing import NEVER_NS, Sensing
from pmwvc_core.law.safety.brakes import HAND_RETURN_S, brake_stiffness
from pmwvc_core.law.safety.limits import LARGEST, REACH, limits_params, resting_limits
from pmwvc_core.law.user_tick import FrameParams, Frames, User, UserParams
from pmwvc_core.law.without_waves.device_end import DeviceEndParams, resting_end
from pmwvc_core.made.waves import resting_waves, waves_params
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import largest_wave, wave_of_speed

NEVER = 1 << 62  # ticks
REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most


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
    return UserParams(
        FrameParams(master.rate_drop, answer_tick, tick_s),
        packing_params(master.deadband),
        arrivals,
        port,
        limits_params(safety, tick_s, packet_s, reach, stiffness),
    )


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
        port: Any = Plugged(law, nothing, nothing, came, False, False, answer, nothing, sums_j)
    elif record.law is not None:
        port = resting_end(law, axes)
    else:
        port = resting_waves(master, p.port, axes)
    return User(
        Frames(0, 0, master.rate_drop),
        master.frame_s,
        resting_packing(axes),
        start_of(p.arrivals.plays_on, axes, user.safety.timeout_s, packet_s),
        packet,
        0,
        port,
        resting_limits(nothing, p.limits),
        Sensing(nothing, NEVER_NS, 0),
        NEVER,
        False,
    )
