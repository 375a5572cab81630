# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Implicit: avatars and object solved together by the midpoint rule; energy balances exactly.

With the mean velocity v of the object over the step and w_i = xd_si - v::

    f_i    = contact law (w_i),         w_i = sqrt(2/b_i) u_i - f_i/b_i - v
    sum f_i = m_o (v1 - v0)/h + b_o v,   v = (v0 + v1)/2
    x_o += h v,  x_si += h xd_si

so that, whatever the waves, stiffnesses and step::

    d(kinetic) + d(potential) + heat = h sum (|u_i|^2 - |v_i|^2)/2

Each f_i falls with v, at most by b_i per m/s, so the object's equation has one root and its slope
is at least 2 m_o/h + b_o. Two-sided contacts are linear: one Newton step is the closed form.
One-sided contacts are solved exactly for a given v (``grip``) and the root is found by Newton's
method kept inside a bracket that halves when it must; axis by axis, or all axes at once where a
wave impedance couples them (:mod:`.coupled_axes`).

Equations: docs/theory.md 4.4, 4.5.
"""

import sys
from collections.abc import Callable, Sequence

import numpy as np

from pmwvc_core.numeric import Flag, Value, absolute, maximum, minimum, truth, where
from pmwvc_core.params import ServerParams
from pmwvc_core.server.black_box.faults import Faults, Unsettled
from pmwvc_core.server.contacts import Answer
from pmwvc_core.server.couplings.coupled_axes import solve_coupled
from pmwvc_core.server.couplings.record import Coupling, backward
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.wave.impedance import MatrixImpedance

_ROUNDING = 8.0 * sys.float_info.epsilon
_NEWTON = 20  # steps before halving alone is trusted
_LIMIT = 90  # then the bracket is as narrow as numbers are


class Implicit:
    """Solve everything together."""

    def __init__(self, params: ServerParams) -> None:
        self._period = params.period_s
        self.faults = Faults("server.coupling", params.coupling)

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """Use every port's ``u_s``; return the energy dissipated [J]."""
        h = self._period
        driven = []
        coupled = False
        for port in ports:
            driven.append((port.contact, port.b, port.wave.free_velocity(port.u_s)))
            coupled = coupled or isinstance(port.b, MatrixImpedance)

        def ask(velocity: Value) -> list[tuple[Value, Answer]]:
            asked = []
            for contact, b, drive in driven:
                rate = drive - velocity
                asked.append((rate, contact.answer(rate, b, h)))
            return asked

        if coupled:
            velocity, answers, settled = solve_coupled(ask, body)
            if not settled.all():
                self.faults.note(Unsettled(f"({np.count_nonzero(~settled)} of {settled.size})"))
        else:
            velocity, answers = solve(ask, body)
        lost = body.drift(velocity)
        for port, answer, (contact, b, drive) in zip(ports, answers, driven, strict=True):
            port.f_s = force = answer.force
            port.xd_s = drive - force / b
            lost = lost + contact.advance(answer, h)
        return lost


def solve(
    ask: Callable[[Value], list[tuple[Value, Answer]]], body: Body
) -> tuple[Value, list[Answer]]:
    """Return the object's mean velocity [m/s] and the answers of all contacts to it.

    ``ask`` returns for a mean velocity of the object per contact what the velocity relative to it
    would be without the contact, and the answer.
    """
    velocity = body.xd
    low = high = velocity
    for turn in range(_LIMIT):
        answers = []
        force: Value = 0.0
        slope: Value = 0.0
        size: Value = 0.0  # of the terms that may cancel, hence of rounding [N]
        for free, answer in ask(velocity):
            answers.append(answer)
            push, fall = answer.force, answer.slope
            force = force + push
            slope = slope + fall
            size = size + absolute(push) + fall * absolute(free)
        missing = body.imbalance(velocity, force)
        mobility = body.mobility(slope)
        change = missing * mobility
        settled = absolute(change) <= _ROUNDING * (absolute(velocity) + mobility * size)
        if truth(settled):
            break
        if turn == 0:
            other = velocity - missing * body.mobility(0.0 * slope)
            low, high = minimum(velocity, other), maximum(velocity, other)
        else:
            low = where(missing < 0.0, velocity, low)
            high = where(missing < 0.0, high, velocity)
        velocity = where(settled, velocity, _next(velocity - change, low, high, turn))
    return velocity, answers


def _next(newton: Value, low: Value, high: Value, turn: int) -> Value:
    """Return Newton's guess where it is of use, else the middle of the bracket."""
    outside: Flag = (newton < low) | (newton > high) if turn < _NEWTON else newton == newton
    return where(outside, 0.5 * (low + high), newton)


RECORD = Coupling(
    name="implicit",
    words="Avatars and object are solved together: energy balances exactly in every step.",
    linear="implicit",
    make=Implicit,
    moves=backward,
    balanced=True,
    exact=True,
    object_motion="midpoint",
    passive=lambda params: True,
)
