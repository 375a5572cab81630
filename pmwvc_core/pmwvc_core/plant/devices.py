# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated force-feedback device: m x'' + b_hd x' = f_h - F_m, plus what a real one adds.

* Mass and damper are advanced exactly over a tick with both forces held (:mod:`..motion`).
* Coulomb friction is one vector against the direction of motion, the same whatever the axes. Its
  direction is that at the start of a tick; along one axis it is integrated exactly: where it stops
  the device within a tick, the rest of the tick starts from the point of rest, and it stays there
  unless the other forces overcome the friction. It only ever takes energy.
* The stops at the ends of the workspace are perfectly inelastic: position at the stop, velocity
  zero.
* Time that a force loop misses passes at the device, with the last force held, but no more than
  ``CATCH_UP_S`` at once: beyond that it stands still, as a device with a watchdog.
* The encoder rounds to its nearest step; the velocity signal is the true one, or the difference of
  the last two readings over a tick, which is half a tick late.

Not here: force limits of the device (``master.safety``).
"""

import math

import numpy as np

from pmwvc_core.account import Account
from pmwvc_core.errors import ParameterError
from pmwvc_core.motion import Motion, damper_heat, motion, time_to_rest
from pmwvc_core.numeric import (
    Value,
    absolute,
    anywhere,
    clip,
    dot,
    maximum,
    minimum,
    root,
    squared,
    where,
)
from pmwvc_core.params import DeviceParams

CATCH_UP_S = 0.1


class SimulatedDevice:
    """A damped mass with encoder and stops, at rest at the origin at first.

    Parameters
    ----------
    params
        The device; numbers may be ``(runs, 1)``.
    dof
        Number of axes; more than one makes all signals arrays ``(..., dof)``.
    """

    SIGNALS = "x xd _read"
    MEMORY = "work"

    def __init__(self, params: DeviceParams, *, tick_s: float, dof: int) -> None:
        self._mass, self._damping = params.mass, params.damping
        self._friction = params.friction
        self._step_m = params.encoder_step_m
        self._reach = params.workspace_m
        self._tick_s = tick_s
        self._dof = dof
        self._motion: Motion = motion(params.mass, params.damping, tick_s)
        self._rubs = bool(np.any(np.asarray(params.friction) > 0.0))
        self._rounds = bool(np.any(np.asarray(params.encoder_step_m) > 0.0))
        self._differences = params.differences
        self.x: Value = 0.0  # [m] the true one
        self.xd: Value = 0.0  # [m/s] the true one
        # [J] of the controller's force against the hand, and of the hand's force on the device:
        # force held over each tick times the true distance moved in it
        self.work: tuple[Value, Value] = (0.0, 0.0)
        self._read: tuple[Value, Value] = (0.0, 0.0)
        self.place(0.0)

    def place(self, x: Value) -> None:
        """Put the device somewhere, at rest; ParameterError where that is outside the workspace.

        Parameters
        ----------
        x
            Position [m], a vector ``(..., dof)``; a single number (or ``(runs, 1)``) is that along
            axis 0, the others being zero.
        """
        position = along_first_axis(x, self._dof)
        if np.any(np.abs(position) > self._reach):
            raise ParameterError(
                f"device placed at {np.asarray(x).tolist()} m: outside its workspace of "
                f"+-{np.asarray(self._reach).tolist()} m; make device.workspace_m larger"
            )
        self.x = position
        self.xd = position * 0.0
        self._read = (self._measured(), self.xd)

    def step(self, f_h: Value, f_m: Value) -> tuple[Value, Value]:
        """Advance one tick, with the force ``f_h`` of the hand on the device and that of the
        controller against it, ``f_m``, held [N]; return what is read at its end.
        """
        if self._rubs:
            x, xd = self._rub(f_h - f_m)
        else:
            x, xd = self._motion.advance(self.x, self.xd, f_h - f_m)
        stopped = absolute(x) >= self._reach
        if stopped is not False and anywhere(stopped):
            x = clip(x, -self._reach, self._reach)
            xd = where(stopped, 0.0 * xd, xd)
        moved = x - self.x
        against, by_hand = self.work
        self.work = against + dot(f_m, moved), by_hand + dot(f_h, moved)
        self.x, self.xd = x, xd
        measured = self._measured() if self._rounds else x
        if self._differences:
            xd = (measured - self._read[0]) / self._tick_s
        self._read = read = (measured, xd)
        return read

    def read(self) -> tuple[Value, Value]:
        """Return measured position [m] and velocity [m/s] at this instant."""
        return self._read

    def _measured(self) -> Value:
        """Return what the encoder shows."""
        if not self._rounds:
            return self.x
        step = where(self._step_m > 0.0, self._step_m, 1.0)
        count = self.x / step + 0.5
        whole = np.floor(count) if isinstance(count, np.ndarray) else float(math.floor(count))
        return where(self._step_m > 0.0, whole * step, self.x)

    def _rub(self, force: Value) -> tuple[Value, Value]:
        """Advance one tick with Coulomb friction against the direction of motion.

        That direction is kept over the tick, or until the motion along it has come to rest: along
        it the velocity is monotone and passes zero at most once. From there the other forces
        either hold still or win for good, in their own direction.
        """
        holding = self._friction
        push = _direction(force) * maximum(_length(force) - holding, 0.0)  # what wins from rest
        speed, course = _length(self.xd), _direction(self.xd)
        net = where(speed > 0.0, force - course * holding, push)
        x, xd = self._motion.advance(self.x, self.xd, net)
        turns = dot(course, xd) < 0.0
        if not anywhere(turns):
            return x, xd
        along = where(turns, dot(course, net), -1.0)
        time_s = time_to_rest(self._mass, self._damping, speed, along)
        time_s = where(turns, minimum(maximum(time_s, 0.0), self._tick_s), 0.0)
        x_rest, across = motion(self._mass, self._damping, time_s).advance(self.x, self.xd, net)
        held = _length(force) <= holding
        across = where(held, 0.0 * xd, across - course * dot(course, across))
        after = motion(self._mass, self._damping, self._tick_s - time_s)
        x_after, xd_after = after.advance(x_rest, across, push)
        return where(turns, x_after, x), where(turns, xd_after, xd)


def device_account(
    params: DeviceParams,
    tick_s: float,
    before: tuple[Value, Value],
    after: tuple[Value, Value],
    f_h: Value | None,
    f_m: Value,
) -> Account:
    """Return the energy of a device over a tick of which its true motion is known [J].

    ::

        taken       f_h . (x+ - x), a force held over a tick works on what it moves
        given       f_m . (x+ - x), to the force of the controller
        stored      m (|xd+|^2 - |xd|^2)/2
        dissipated  b_hd times the integral of |xd|^2, and friction |x+ - x|; at a stop the rest

    Parameters
    ----------
    before, after
        Position [m] and velocity [m/s] at the start and at the end of the tick.
    f_h, f_m
        Forces of the hand and of the controller [N]. A hand whose force is not known (None) is
        taken to have given what the device shows.
    """
    (x, xd), (x_after, xd_after) = before, after
    moved = x_after - x
    push = -f_m if f_h is None else f_h - f_m
    stored = 0.5 * params.mass * (squared(xd_after) - squared(xd))
    if f_h is not None and params.friction == 0.0:
        heat = damper_heat(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        square = squared(xd) + dot(xd, xd_after) + squared(xd_after)
        heat = params.damping * tick_s / 3.0 * square
    heat = heat + params.friction * root(squared(moved))
    stopped = squared(where(absolute(x_after) >= params.workspace_m, 1.0, 0.0))
    heat = where(stopped > 0.0, dot(push, moved) - stored, heat)
    given = dot(f_m, moved)
    taken = given + stored + heat if f_h is None else dot(f_h, moved)
    return Account(taken, given, stored, heat)


def _length(vector: Value) -> Value:
    return absolute(vector) if isinstance(vector, float) else root(squared(vector))


def _direction(vector: Value) -> Value:
    """Return the unit vector; nothing where there is none."""
    length = _length(vector)
    return vector / where(length > 0.0, length, 1.0)


def along_first_axis(value: Value, dof: int) -> Value:
    """Return a vector with this value on axis 0 and zero elsewhere; vectors pass unchanged."""
    if dof == 1:
        return float(value) if np.ndim(value) == 0 else value
    array = np.asarray(value, dtype=float)
    if array.ndim and array.shape[-1] == dof:
        return array
    vector = np.zeros((*array.shape[:-1], dof))
    vector[..., 0] = array[..., 0] if array.ndim else array
    return vector
