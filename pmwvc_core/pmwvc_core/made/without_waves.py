# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of the controllers without waves, made from parameters."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_core.controllers.plugged import DeviceAnswer
from pmwvc_core.controllers.plugged_ends import Plugged, PluggedParams
from pmwvc_core.controllers.record import Controller
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.family import NOTHING
from pmwvc_core.law.without_waves.device_end import DeviceEnd, DeviceEndParams, resting_end
from pmwvc_core.law.without_waves.direct import Direct, Held
from pmwvc_core.law.without_waves.pspm import Pspm, resting_pspm, resting_spring
from pmwvc_core.law.without_waves.tdpa import RESTING_OBSERVER, resting_tdpa, tdpa_law
from pmwvc_core.law.without_waves.virtual_coupling import VirtualCoupling, resting_coupling
from pmwvc_core.params import BaselineParams
from pmwvc_core.scenario import scenario as scenarios


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


def device_params(record: Controller, user: "scenarios.User") -> DeviceEndParams | PluggedParams:
    """Return the parameters of a device's end."""
    tick_s = user.master.tick_s
    if record.device is None:
        return DeviceEndParams(tick_s, CONTROLLERS[record.name].law(user.baseline, tick_s))
    values = own_values(user, record)
    return PluggedParams(record.device, values, record.energies, tick_s, record.waves)


def resting_device_end(
    record: Controller, user: "scenarios.User", nothing: Packet
) -> DeviceEnd | Plugged:
    """Return a device's end at rest; ``nothing`` stands for a packet before the first."""
    rest = nothing.wave
    if record.device is None:
        at_device = CONTROLLERS[record.name].at_device(user.baseline, len(rest))
        return resting_end(at_device, len(rest))
    up, down = record.extra(len(rest))
    law = record.device_rest(own_values(user, record), len(rest))
    answer = DeviceAnswer(rest, rest, (0.0,) * up)
    packet = nothing._replace(extra=(0.0,) * down)
    return Plugged(law, rest, rest, packet, False, False, answer, rest, (0.0,) * 4)
