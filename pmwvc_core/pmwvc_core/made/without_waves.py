# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of the controllers without waves, made from parameters."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_core.law.without_waves.device_end import DeviceEnd, DeviceEndParams, resting_end
from pmwvc_core.law.without_waves.direct import Direct, Held, NothingKept
from pmwvc_core.law.without_waves.pspm import Pspm, resting_pspm, resting_spring
from pmwvc_core.law.without_waves.tdpa import RESTING_OBSERVER, resting_tdpa, tdpa_law
from pmwvc_core.law.without_waves.virtual_coupling import VirtualCoupling, resting_coupling
from pmwvc_core.params import BaselineParams


class Made(NamedTuple):
    """How a controller is made: its law for a tick [s], what its device's end and its avatar start
    from, by number of axes; whether avatars hang on springs.
    """

    law: Callable[[BaselineParams, float], Any]
    at_device: Callable[[BaselineParams, int], Any]
    at_avatar: Callable[[BaselineParams, int], Any]
    sprung: bool


def _nothing(baseline: BaselineParams, axes: int) -> NothingKept:
    return NothingKept(0)


def _spring_damper(baseline: BaselineParams, tick_s: float) -> VirtualCoupling:
    coupling = baseline.virtual_coupling
    return VirtualCoupling(coupling.stiffness, coupling.damping)


def _pspm(baseline: BaselineParams, tick_s: float) -> Pspm:
    return Pspm(baseline.pspm.stiffness, baseline.pspm.damping, baseline.pspm.cap_j)


CONTROLLERS: Mapping[str, Made] = {
    "direct": Made(
        lambda baseline, tick_s: Direct(0),
        lambda baseline, axes: Held((0.0,) * axes),
        _nothing,
        sprung=False,
    ),
    "virtual_coupling": Made(
        _spring_damper, lambda baseline, axes: resting_coupling(axes), _nothing, sprung=True
    ),
    "tdpa": Made(
        lambda baseline, tick_s: tdpa_law(baseline.tdpa, tick_s),
        lambda baseline, axes: resting_tdpa(axes),
        lambda baseline, axes: RESTING_OBSERVER,
        sprung=False,
    ),
    "pspm": Made(
        _pspm,
        lambda baseline, axes: resting_pspm(axes, baseline.pspm.initial_j),
        lambda baseline, axes: resting_spring(axes, baseline.pspm.initial_j),
        sprung=True,
    ),
}


def device_params(controller: str, baseline: BaselineParams, tick_s: float) -> DeviceEndParams:
    """Return the parameters of a device's end."""
    return DeviceEndParams(tick_s, CONTROLLERS[controller].law(baseline, tick_s))


def resting_device_end(controller: str, baseline: BaselineParams, axes: int) -> DeviceEnd:
    """Return a device's end at rest."""
    return resting_end(CONTROLLERS[controller].at_device(baseline, axes), axes)
