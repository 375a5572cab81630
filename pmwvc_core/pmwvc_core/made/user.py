# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's force loop, made from a scenario."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing, record_of
from pmwvc_core.controllers.plugged import DeviceAnswer
from pmwvc_core.controllers.plugged_ends import Plugged, PluggedParams
from pmwvc_core.controllers.record import Controller
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.packet import no_packet, packing_params, resting_packing
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import NOTHING
from pmwvc_core.law.port.sensing import NEVER_NS
from pmwvc_core.law.safety.brakes import HAND_RETURN_S, brake_stiffness
from pmwvc_core.law.safety.limits import LARGEST, REACH, limits_params, resting_limits
from pmwvc_core.law.user_tick import User, UserParams
from pmwvc_core.law.without_waves.device_end import DeviceEndParams, resting_end
from pmwvc_core.law.without_waves.direct import Direct, Held
from pmwvc_core.law.without_waves.pspm import Pspm, resting_pspm, resting_spring
from pmwvc_core.law.without_waves.tdpa import RESTING_OBSERVER, resting_tdpa, tdpa_law
from pmwvc_core.law.without_waves.virtual_coupling import VirtualCoupling, resting_coupling
from pmwvc_core.made.waves import resting_waves, waves_params
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.impedance import largest_wave, wave_of_speed

NEVER = 1 << 62  # ticks
REPAID_M_S = 0.06  # speed at which device and avatar come together after an outage, at most


class Made(NamedTuple):
    """How a controller is made: its law for a tick [s], what its device's end and its avatar start
    from, by number of axes; whether avatars hang on springs.
    """

    law: Callable[[BaselineParams, float], Any]
    at_device: Callable[[BaselineParams, int], Any]
    at_avatar: Callable[[BaselineParams, int], Any] = lambda baseline, axes: NOTHING
    sprung: bool = False


CONTROLLERS: Mapping[str, Made] = {
    "direct": Made(lambda baseline, tick_s: Direct(0), lambda baseline, axes: Held((0.0,) * axes)),
    "virtual_coupling": Made(
        lambda baseline, tick_s: VirtualCoupling(
            baseline.virtual_coupling.stiffness, baseline.virtual_coupling.damping
        ),
        lambda baseline, axes: resting_coupling(axes),
        sprung=True,
    ),
    "tdpa": Made(
        lambda baseline, tick_s: tdpa_law(baseline.tdpa, tick_s),
        lambda baseline, axes: resting_tdpa(axes),
        lambda baseline, axes: RESTING_OBSERVER,
    ),
    "pspm": Made(
        lambda baseline, tick_s: Pspm(
            baseline.pspm.stiffness, baseline.pspm.damping, baseline.pspm.cap_j
        ),
        lambda baseline, axes: resting_pspm(axes, baseline.pspm.initial_j),
        lambda baseline, axes: resting_spring(axes, baseline.pspm.initial_j),
        sprung=True,
    ),
}


def own_values(user: "scenarios.User", record: Controller) -> Any:
    """Return a user's parameters of a controller of another package; None without any."""
    return getattr(user.own, record.name) if record.params else None


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
    record, tick_s = record_of(controller), master.tick_s
    if record.device is not None:
        values = own_values(user, record)
        port: Any = PluggedParams(record.device, values, record.energies, tick_s, record.waves)
    elif record.waves:
        port = waves_params(master, b, arrivals.playout, strict=strict)
    else:
        port = DeviceEndParams(tick_s, CONTROLLERS[controller].law(user.baseline, tick_s))
    limits = limits_params(user.safety, tick_s, packet_s, reach, stiffness)
    packing = packing_params(master.deadband)
    return UserParams(master.rate_drop, answer_tick, tick_s, packing, arrivals, port, limits)


def resting_user(
    user: "scenarios.User", p: UserParams, *, controller: str, axes: int, packet_s: float
) -> User:
    """Return a user's force loop at rest."""
    nothing, master = (0.0,) * axes, user.master
    timeout_s = user.safety.timeout_s
    record, packet = record_of(controller), no_packet(nothing, ())
    if record.device is not None:
        up, down = record.extra(axes)
        law = record.device_rest(own_values(user, record), axes)
        answer = DeviceAnswer(nothing, nothing, (0.0,) * up)
        came, sums_j = packet._replace(extra=(0.0,) * down), (0.0,) * 4
        port: Any = Plugged(law, nothing, nothing, came, False, False, answer, nothing, sums_j)
    elif record.waves:
        port = resting_waves(master, p.port, axes)
    else:
        port = resting_end(CONTROLLERS[controller].at_device(user.baseline, axes), axes)
    arrivals = start_of(p.arrivals.plays_on, axes, timeout_s, packet_s)
    return User(
        0, 0, master.rate_drop, master.frame_s, resting_packing(axes), arrivals, packet, 0, port,
        resting_limits(nothing, p.limits), nothing, NEVER_NS, 0, NEVER, False,
    )  # fmt: skip
