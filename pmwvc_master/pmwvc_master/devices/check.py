# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a device does, seen before a session: how often and how late it answers, its noise, the
signs, order and units of its axes, velocities against positions; and, where a force is asked for,
which way it pushes, and whether it goes on pushing when nobody calls it. Forces rise and fall at
``SLEW_N_S``, and end where the handle gets fast or far.
"""

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

from pmwvc_core.ends.inbox import value
from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Array, flatten
from pmwvc_core.runtime.pacing import Pacer, Tick
from pmwvc_core.runtime.process import refuse_undeclared
from pmwvc_master.devices import HapticDevice, limits_of, make_device
from pmwvc_master.devices.listing import DeviceLine
from pmwvc_master.devices.plausible import OFF, Slope
from pmwvc_master.settings import declare_settings

BEFORE_S, REST_S, MOVE_S, PUSH_S = 3.0, 2.0, 5.0, 0.5
BRIEF_S, SILENT_S = 0.15, 0.05  # a push, and then no call
SLOWEST_HZ = 200.0  # of new samples, for stiff contacts
SLEW_N_S, LARGEST_N = 2.0, 1.0
FAST_M_S, AWAY_M = 0.3, 0.03  # a push ends there
MOVED_M, FARTHEST_M = 0.01, 0.6  # by a hand
SHIFTED_M, PUSHED_M_S = 0.0005, 0.005  # by a push, at least
NOISE_M = 0.001  # peak to peak
DIRECTIONS = ("+x, along which the users meet", "+y", "+z")
Push: TypeAlias = tuple[int, float, float]  # axis, largest force, force at the end [N]
Clock: TypeAlias = Callable[[float], Iterable[Tick]]
Ask: TypeAlias = Callable[[str], object]


class NewSamples(NamedTuple):
    """New samples: times and ages [s], motion (samples, dof)."""

    t: Array
    x: Array
    xd: Array
    ages: Array


class DeviceCheck:
    """One check of a device: ``clock`` gives the ticks of a time [s], ``ask`` asks a person."""

    def __init__(self, device: HapticDevice, tick_s: float, clock: Clock, ask: Ask) -> None:
        self._device, self._tick_s, self._clock, self._ask = device, tick_s, clock, ask

    def lines(self, push_n: float = 0.0) -> Iterator[DeviceLine]:
        """Yield what is seen; the hand is pushed where a force is given."""
        axes = range(self._device.info.dof)
        self._ask("Keep the handle still")
        yield from at_rest(self._seen(REST_S), REST_S)
        motions = []
        for axis in axes:
            self._ask(f"Move the handle along {DIRECTIONS[axis]}, some centimetres, not back")
            motions.append(self._seen(MOVE_S))
            yield along(motions[-1], axis)
        yield slopes(motions)
        for axis in axes if push_n else ():
            self._ask(f"Let the handle give way to {push_n:g} N along {DIRECTIONS[axis]}")
            yield self._pushed(axis, push_n)
        if push_n:
            self._ask(f"The last time: let the handle give way along {DIRECTIONS[0]}")
            yield self._without_calls(push_n)

    def _seen(self, seconds: float, push: Push = (0, 0.0, 0.0)) -> NewSamples:
        """Read for a time, pushing the hand; the push rises, and falls to its end."""
        rows, ages, first = [], [], None
        step_n, count = SLEW_N_S * self._tick_s, round(seconds / self._tick_s)
        axis, push_n, end_n = push
        for k, tick in enumerate(self._clock(seconds)):
            sample = self._device.read(tick.due_ns)
            x, xd = flatten(sample.x), flatten(sample.xd)
            if not sample.valid:
                push_n = end_n = 0.0
            elif sample.fresh:
                first = x if first is None else first
                ages.append((tick.woke_ns - (sample.measured_ns or tick.woke_ns)) * 1e-9)
                rows.append((tick.due_ns * 1e-9, x, xd))
                if np.abs(xd).max() > FAST_M_S or np.abs(x - first).max() > AWAY_M:
                    push_n = end_n = 0.0
            f_m = 0.0 * x
            f_m[axis] = -min(push_n, (k + 1) * step_n, end_n + (count - 1 - k) * step_n)
            self._device.write(value(tuple(f_m.tolist())))
        if not rows:
            raise DeviceError(f"{self._device.info.model}: no valid sample in {seconds:g} s")
        t, xs, xds = (np.array(each) for each in zip(*rows, strict=True))
        return NewSamples(t, xs, xds, np.array(ages))

    def _pushed(self, axis: int, push_n: float) -> DeviceLine:
        """Push along an axis; return whether the handle gave way in that direction."""
        by = farthest(self._seen(PUSH_S, (axis, push_n, 0.0)))[axis]
        text = f"push along axis {axis}: {1e3 * by:+.3g} mm"
        wrong = "" if by > 0.0 else ": forces and motions differ in sign"
        wrong = wrong if abs(by) >= SHIFTED_M else ": held fast, or no force"
        return DeviceLine(not wrong, text + wrong)

    def _without_calls(self, push_n: float) -> DeviceLine:
        """Push, call nothing for a while, and return whether the push went on."""
        before = self._seen(BRIEF_S, (0, push_n, push_n))
        for _ in self._clock(SILENT_S):
            pass
        after = self._seen(0.02)
        self._device.stop()
        last, earlier = before.xd[-1, 0], before.xd[before.t <= before.t[-1] - SILENT_S, 0]
        usual, faster = last - (earlier[-1] if len(earlier) else 0.0), after.xd[0, 0] - last
        text = f"{SILENT_S:g} s without a call: {1e3 * faster:+.3g} mm/s"
        if usual < PUSHED_M_S:
            return DeviceLine(True, f"{text}: no result, the handle was held")
        on = faster > 0.5 * usual
        return DeviceLine(not on, f"{text}: {'the push went on' if on else 'the push ended'}")


def farthest(there: NewSamples) -> Array:
    """Return the largest displacement from the first sample (dof,)."""
    by = there.x - there.x[0]
    largest: Array = by[np.argmax(np.abs(by).max(axis=1))]
    return largest


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


def along(there: NewSamples, axis: int) -> DeviceLine:
    """Return whether a motion was along an axis, forwards, and in metres."""
    by = farthest(there)
    main = int(np.argmax(np.abs(by)))
    text = f"axis {axis}: {1e3 * by[main]:+.3g} mm along axis {main}"
    if not MOVED_M <= abs(by[main]) <= FARTHEST_M:
        return DeviceLine(False, f"{text}: was it moved so? If it was, are these metres?")
    turned = "" if by[axis] == abs(by[main]) else ": change order or signs of the device's axes"
    return DeviceLine(not turned, text + turned)


def slopes(motions: list[NewSamples]) -> DeviceLine:
    """Return whether velocities are those of the positions."""
    slope, ratios = Slope(), []
    for there in motions:
        for t, x, xd in zip(there.t.tolist(), there.x, there.xd, strict=True):
            ratios += [each] if (each := slope.add(round(t * 1e9), x, xd)) is not None else []
    if not ratios:
        return DeviceLine(False, "velocity: too little motion for a result")
    ratio = float(np.median(ratios))
    return DeviceLine(1 / OFF < ratio < OFF, f"velocity: {ratio:.3g} times the positions' slope")


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
        device = make_device(settings.device.plugin, settings.device_setup(node))
        refuse_undeclared(node)
        most_n = min(limits_of(device.info, settings.safety).max_force, LARGEST_N)
        if not 0.0 <= push_n <= most_n:
            raise DeviceError(f"--force {push_n:g}: must be 0..{most_n:g} N")
        device.open()
        ends.callback(device.close)
        ends.callback(device.stop)
        pacer, tick_s = Pacer(round(settings.master.tick_s * 1e9)), settings.master.tick_s

        def clock(seconds: float) -> Iterable[Tick]:
            return (pacer.wait() for _ in range(round(seconds / tick_s)))

        def ask(text: str) -> None:
            print(f"{text} (in {BEFORE_S:g} s)", flush=True)
            time.sleep(BEFORE_S)

        yield from DeviceCheck(device, tick_s, clock, ask).lines(push_n)
