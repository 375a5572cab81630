# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's force loop, made from a scenario."""

from typing import Any

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing, record_of
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.packet import no_packet, packing_params, resting_packing
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.port.sensing import NEVER_NS, Sensing
from pmwvc_core.law.safety.brakes import HAND_RETURN_S, brake_stiffness
from pmwvc_core.law.safety.limits import LARGEST, REACH, limits_params, resting_limits
from pmwvc_core.law.user_tick import FrameParams, Frames, User, UserParams
from pmwvc_core.made.waves import resting_waves, waves_params
from pmwvc_core.made.without_waves import device_params, resting_device_end
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import largest_wave, wave_of_speed

NEVER = 1 << 62  # ticks
REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most


def arrivals_params(
    controller: str, channel: str, b: Any, *, timeout_s: float, lets_go_s: float, store_j: float
) -> ArrivalsParams:
    """Return the rules of a receiver of a port of this impedance [N s/m], whose brake lets go in
    so much time after an outage [s], and whose playout begins with so much energy [J].
    """
    strict, waves = is_strict(controller, channel), has_waves(controller)
    repaid = float(wave_of_speed(b, REPAID_M_S))
    return ArrivalsParams(
        timeout_s,
        float(largest_wave(b, waves=waves)),
        is_zeroing(controller, channel),
        strict,
        PlayoutParams(repaid, lets_go_s, store_j),
    )


def user_params(
    user: "scenarios.User",
    *,
    controller: str,
    channel: str,
    packet_s: float,
    answer_tick: int,
    workspace_m: float | None = None,
) -> UserParams:
    """Return the parameters of a user's force loop."""
    master, b = user.master, user.impedance
    strict = is_strict(controller, channel)
    arrivals = arrivals_params(
        controller,
        channel,
        b,
        timeout_s=user.safety.timeout_s,
        lets_go_s=HAND_RETURN_S,
        store_j=master.store_j,
    )
    stiffness = brake_stiffness(impedances.smallest(b)) if strict else 0.0
    reach = LARGEST if workspace_m is None else REACH * workspace_m
    record = record_of(controller)
    if record.waves and record.device is None:
        port: Any = waves_params(master, b, arrivals.playout, strict=strict)
    else:
        port = device_params(record, user)
    return UserParams(
        FrameParams(master.rate_drop, answer_tick, master.tick_s),
        packing_params(master.deadband),
        arrivals,
        port,
        limits_params(user.safety, master.tick_s, packet_s, reach, stiffness),
    )


def resting_user(
    user: "scenarios.User", p: UserParams, *, controller: str, axes: int, packet_s: float
) -> User:
    """Return a user's force loop at rest."""
    nothing, master = (0.0,) * axes, user.master
    timeout_s = user.safety.timeout_s
    record, packet = record_of(controller), no_packet(nothing, ())
    if record.waves and record.device is None:
        port: Any = resting_waves(master, p.port, axes)
    else:
        port = resting_device_end(record, user, packet)
    return User(
        Frames(0, 0, master.rate_drop),
        master.frame_s,
        resting_packing(axes),
        start_of(p.arrivals.plays_on, axes, timeout_s, packet_s),
        packet,
        0,
        port,
        resting_limits(nothing, p.limits),
        Sensing(nothing, NEVER_NS, 0),
        NEVER,
        False,
    )
