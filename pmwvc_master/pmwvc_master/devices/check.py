# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which kinds of device there are and what each finds here (a plug-in may have ``look()``: a text,
or a DeviceError with what is missing); and what one does before a session: rate and age of its
samples, noise, signs, order and units of its axes, velocities; with a force, which way it pushes,
and whether that goes on when nobody calls. A push rises and falls at ``SLEW_N_S``.
"""

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError, PmwvcError
from pmwvc_core.numeric import Array, flatten
from pmwvc_core.plugins import installed
from pmwvc_core.runtime.pacing import Pacer
from pmwvc_core.runtime.process import refuse_undeclared
from pmwvc_master.devices import PLUGINS, limits_of
from pmwvc_master.devices.mapped import Mapped, make_device
from pmwvc_master.devices.plausible import OFF
from pmwvc_master.settings import declare_settings

BEFORE_S, REST_S, MOVE_S, PUSH_S, BRIEF_S, SILENT_S = 3.0, 2.0, 5.0, 0.5, 0.15, 0.05
SLOWEST_HZ, NOISE_M = 200.0, 0.001  # of new samples, for stiff contacts; peak to peak
SLEW_N_S, LARGEST_N, FAST_M_S, AWAY_M = 2.0, 1.0, 0.3, 0.03  # the last two end a push
MOVED_M, FARTHEST_M, SHIFTED_M, PUSHED_M_S = 0.01, 0.6, 0.0005, 0.005  # by a hand; by a push
HOW = "was it moved so? If it was, are these metres?"
DIRECTIONS = ("+x, along which the users meet", "+y", "+z", *(f"turns about {n}" for n in "xyz"))


class DeviceLine(NamedTuple):
    """A text about a device, and whether all is as it should be."""

    right: bool
    text: str


def listed() -> Iterator[DeviceLine]:
    """Yield a line for each kind of device that is installed."""
    for name in installed(PLUGINS.group):
        try:
            factory = PLUGINS.load(name)
            text = factory.look() if hasattr(factory, "look") else "installed"
            yield DeviceLine(True, f"{name}: {text}")
        except PmwvcError as error:
            yield DeviceLine(False, f"{name}: {error}")


class NewSamples(NamedTuple):
    """New samples: times and ages [s], motion (samples, dof)."""

    t: Array
    x: Array
    xd: Array
    ages: Array


class DeviceCheck:
    """One check of an open device; ``ask`` asks a person to do something."""

    def __init__(self, device: Mapped, pacer: Pacer, ask: Callable[[str], object]) -> None:
        self._device, self._pacer, self._ask = device, pacer, ask
        self._tick_s = pacer.period_ns * 1e-9

    def lines(self, push_n: float = 0.0) -> Iterator[DeviceLine]:
        """Yield what is seen; the hand is pushed where a force is given."""
        axes = range(self._device.info.dof)
        self._ask("Keep the handle still")
        yield from at_rest(self._seen(REST_S), REST_S)
        for axis in axes:
            self._ask(f"Move the handle along {DIRECTIONS[axis]}, some centimetres, not back")
            yield along(self._seen(MOVE_S), axis, MOVED_M, "motion", HOW)
        ratio = getattr(self._device.device, "ratio", 0.0)  # a simulated device has none
        text = f"{ratio:.3g} times the positions' slope" if ratio else "too little motion"
        yield DeviceLine(1.0 / OFF < ratio < OFF, f"velocity: {text}")
        for axis in axes[:3] if push_n else ():
            self._ask(f"Let the handle give way to {push_n:g} N along {DIRECTIONS[axis]}")
            gave_way = self._seen(PUSH_S, (axis, push_n, 0.0))
            yield along(gave_way, axis, SHIFTED_M, "push", "held fast, or no force?")
        if push_n:
            self._ask(f"The last time: let the handle give way along {DIRECTIONS[0]}")
            yield self._without_calls(push_n)

    def _seen(self, seconds: float, push: tuple[int, float, float] = (0, 0.0, 0.0)) -> NewSamples:
        """Read for a time; a push along an axis rises to a force and falls to another [N]."""
        rows: list[tuple[float, Array, Array, float]] = []
        step_n, count = SLEW_N_S * self._tick_s, round(seconds / self._tick_s)
        axis, push_n, end_n = push
        for k in range(count):
            tick = self._pacer.wait()
            sample = self._device.read(tick.due_ns)
            x, xd = flatten(sample.x), flatten(sample.xd)
            if not sample.valid:
                push_n = end_n = 0.0
            elif sample.fresh:
                age_ns = tick.woke_ns - (sample.measured_ns or tick.woke_ns)
                rows.append((tick.due_ns * 1e-9, x, xd, age_ns * 1e-9))
                if np.abs(xd).max() > FAST_M_S or np.abs(x - rows[0][1]).max() > AWAY_M:
                    push_n = end_n = 0.0
            f_m = 0.0 * x
            f_m[axis] = -min(push_n, (k + 1) * step_n, end_n + (count - 1 - k) * step_n)
            self._device.write(value(tuple(f_m.tolist())))
        if not rows:
            raise DeviceError(f"{self._device.info.model}: no sample in {seconds:g} s; is it on?")
        return NewSamples(*(np.array(each) for each in zip(*rows, strict=True)))

    def _without_calls(self, push_n: float) -> DeviceLine:
        """Push, call nothing for a while, and return whether the push went on."""
        before = self._seen(BRIEF_S, (0, push_n, push_n))
        for _ in range(round(SILENT_S / self._tick_s)):
            self._pacer.wait()
        after = self._seen(0.02)
        self._device.stop()
        last, earlier = before.xd[-1, 0], before.xd[before.t <= before.t[-1] - SILENT_S, 0]
        usual, faster = last - (earlier[-1] if len(earlier) else 0.0), after.xd[0, 0] - last
        text = f"{SILENT_S:g} s without a call: {1e3 * faster:+.3g} mm/s"
        goes_on = faster > 0.5 * usual > 0.5 * PUSHED_M_S
        end = "the push went on" if goes_on else "the push ended, or the handle was held"
        return DeviceLine(not goes_on, f"{text}: {end}")


def at_rest(there: NewSamples, seconds: float) -> Iterator[DeviceLine]:
    """Yield rate and age of samples, and their noise."""
    rate = len(there.t) / seconds
    age, late = (1e3 * float(np.percentile(there.ages, each)) for each in (50, 99))
    text = f"{rate:.0f} new samples a second, {age:.2f} ms old (99 %: {late:.2f} ms)"
    slow = "" if rate >= SLOWEST_HZ else "; too few for stiff contacts"
    yield DeviceLine(not slow, text + slow)
    noise_m, rms = float(np.ptp(there.x, axis=0).max()), float(there.xd.std(axis=0).max())
    text = f"noise: {1e6 * noise_m:.1f} um peak to peak, velocity {1e3 * rms:.2f} mm/s rms"
    moved = "" if noise_m < NOISE_M else "; was the handle still?"
    yield DeviceLine(not moved, text + moved)


def along(there: NewSamples, axis: int, least_m: float, what: str, how: str) -> DeviceLine:
    """Return whether a motion was along an axis, forwards, and in metres."""
    by = there.x - there.x[0]
    by = by[np.argmax(np.abs(by).max(axis=1))]
    main = int(np.argmax(np.abs(by)))
    wrong = "" if by[axis] == abs(by[main]) else ": change order or signs of axes or forces"
    wrong = wrong if least_m <= abs(by[main]) <= FARTHEST_M else f": {how}"
    text = f"{what} along axis {axis}: {1e3 * by[main]:+.3g} mm along axis {main}"
    return DeviceLine(not wrong, text + wrong)


def check_device(given: Mapping[str, Any], push_n: float) -> Iterator[DeviceLine]:
    """Yield what is seen of the device that a master node with these parameters would have."""
    rclpy.init(args=[])
    with contextlib.ExitStack() as ends:
        ends.callback(rclpy.try_shutdown)
        options: dict[str, Any] = {"automatically_declare_parameters_from_overrides": True}
        options["parameter_overrides"] = [Parameter(n, value=given[n]) for n in given]
        node = Node("check", namespace="check", **options)
        ends.callback(node.destroy_node)
        settings = declare_settings(node, lambda _: None, lambda _: None)
        if settings.device.is_simulated:
            text = "its hand moves in sessions only; check a device that is there"
            raise DeviceError(f"device.plugin = {settings.device.plugin!r}: {text}")
        device = make_device(settings.device.plugin, settings.device_setup(node))
        refuse_undeclared(node)
        most_n = min(limits_of(device.info, settings.given_safety).max_force, LARGEST_N)
        if not 0.0 <= push_n <= most_n:
            raise DeviceError(f"--force {push_n:g}: must be 0..{most_n:g} N")
        device.open()
        ends.callback(device.close)
        ends.callback(device.stop)

        def ask(text: str) -> None:
            print(f"{text} (in {BEFORE_S:g} s)", flush=True)
            time.sleep(BEFORE_S)

        pacer = Pacer(round(settings.master.tick_s * 1e9))
        yield from DeviceCheck(device, pacer, ask).lines(push_n)
