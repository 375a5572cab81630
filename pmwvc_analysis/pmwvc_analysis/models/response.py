# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An end stepped once around the hyperperiod from every state, and with every input, at one: what
goes out of it, and its states after, by its states before and what comes in.

A state is any number of the end that answers motion, or what packets say of it, in proportion;
what answers by less (energies) is none. All of them at once, weighted, with either sign, have to
give the sum of what each gives by itself: at the amplitude of a motion, where each is tried at a
tiny one. Whether code of other packages is linear only its author knows: a dead zone, a limit or a
product of signals breaks superposition, and so does state kept elsewhere than in what is returned.
What changes at larger signals only is not seen: the notes of every answer say so. A strict channel
passes a wave only if its energy has come; it is tried at tiny amplitudes alone.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from pmwvc_analysis.models.ends import Came, End, Signals, Slot
from pmwvc_analysis.models.linear import AMPLITUDE, NonlinearError
from pmwvc_core.numeric import Array, Flags

OUTPUTS = ("x", "xd", "f")
OF_DEVICES = (".device.x", ".device.xd")  # ends of names
MOVING = (*OF_DEVICES, ".body.x", ".body.xd")  # and of the object
PLACED = (*MOVING, ".deflection", ".local.x")  # and of springs: what gives a rigid motion
ONE = 2.0**-40  # of a unit, in SI units: limits are far away, and scaling is exact
LESS = 2.0**-20  # of it: what is given a second time, to see what answers in proportion
SUPERPOSED = 1e-9  # relative: what differs by more is not linear
ROUNDING = 1e-14  # of numbers that are not zero at rest
WATCHING = ("still_s", "slow_s", "way_m")  # of counts and jumps: without any, nothing reads them
Signal: TypeAlias = tuple[Slot, int]  # a number of a packet of the hyperperiod


class EndMatrix(NamedTuple):
    """One end, linear: ``matrix (runs, states, sent and read, states, came and forces)``."""

    states: list[str]  # names
    came: list[Signal]
    sent: list[Signal]
    read: int  # rows of x, xd and f: by output, tick and axis
    matrix: Array


class Response:
    """What of an end answers (``states``, by name); with the ``forces`` of a hand along each axis
    in every tick, and the motion read there, where they are asked for. ``like``: an end of which
    the same numbers answer.
    """

    def __init__(self, end: End, forces: bool = False, like: "Response | None" = None) -> None:
        self._end, self._rest, self._numbers = end, end.s, numbers_in(end.s)
        self._forces = end.ticks * end.dof * forces
        self._slots = [
            Slot(way, packet)
            for way, each in enumerate(end.ways)
            for packet in range(len(each.arrivals(each.looked.phase, end.ticks)))
        ]
        self.came = [signal for slot in self._slots for signal in _signals(slot, end.nothing)]
        self.sent: list[Signal] = []
        self._places: dict[str, int] = like._places if like else self._found_places()
        self.states: list[str] = like.states if like else self._found_states()

    def matrix(self, states: Sequence[str] = ()) -> EndMatrix:
        """Return the end by these states, or those that answer; NonlinearError if superposition
        does not hold.
        """
        states, end = list(states or self.states), self._end
        weights, sums = self._weights(states), ONE if end.scenario.strict else AMPLITUDE
        given = np.concatenate([ONE * np.eye(len(weights)), sums * np.array([weights, -weights])])
        answers = self._answers(given, states).T
        n, of_all = len(self._places), list(self._places)
        rows = [*map(of_all.index, states), *range(n, len(answers))]
        whole = answers[rows, :-2] / ONE
        together, opposite = answers[rows, -2:].T / sums
        expected, sizes = whole @ weights, np.abs(whole) @ np.abs(weights)
        off = np.maximum(np.abs(expected - together), np.abs(expected + opposite))
        if (off > SUPERPOSED * sizes.max(initial=0.0)).any():
            raise NonlinearError(
                f"{end.scenario.name}: superposition does not hold for {end.name}; "
                "there is no linear model; use 'pmwvc simulate'"
            )
        read = len(answers) - n - len(self.sent)
        return EndMatrix(states, self.came, self.sent, read, whole[np.newaxis])

    def _weights(self, states: Sequence[str]) -> Array:
        """Return numbers for states, packets and forces."""
        width = len(states) + len(self.came) + self._forces
        rng = np.random.default_rng(width)
        return rng.choice([-2.0, 1.0, 3.0], width) * rng.uniform(0.5, 1.0, width)

    def _answers(self, given: Array, states: Sequence[str]) -> Array:
        """Return what comes of numbers for states, packets and forces ``(cases, numbers)``: all
        numbers that may be states, what is sent and read, ``(cases, numbers)``, less what comes of
        zeros.
        """
        at = [self._places[name] for name in states]
        cases = [[0.0] * given.shape[1], *given.tolist()]
        went = np.array([self._went(case, at) for case in cases])
        kept = np.r_[[*self._places.values()], len(self._numbers) : went.shape[1]]
        rest, moved = went[0, kept], went[1:, kept] - went[0, kept]
        return np.where(np.abs(moved) <= ROUNDING * np.abs(rest), 0.0, moved)

    def _went(self, given: list[float], at: list[int]) -> list[float]:
        """Step with the first numbers at these places; return all numbers, sent and read."""
        end, numbers, n = self._end, self._numbers.copy(), len(at) + len(self.came)
        for place, number in zip(at, given, strict=False):
            numbers[place] = number
        end.s = end.followed(planted(self._rest, iter(numbers)))
        come, forces = iter(given[len(at) : n]), given[n:]
        came: Came = {slot: planted(end.nothing, come) for slot in self._slots}
        read, went = list[Any](), dict[Slot, Signals]()
        for tick in range(end.ticks):
            force = tuple(forces[tick * end.dof :][: end.dof])
            sent, motion = end.step(tick, came, force or end.nothing[0])
            went |= {slot: (p.wave, p.position, p.extra) for slot, p in sent.items()}
            read += [motion] if forces else []
        self.sent = [signal for slot, values in went.items() for signal in _signals(slot, values)]
        motions = [motion[i] for i in range(len(OUTPUTS)) for motion in read]
        return numbers_in((end.s, *went.values(), *motions))

    def _found_states(self) -> list[str]:
        """Return those that motion and packets set in motion."""
        movable = self._end.scenario.environment.movable
        first = MOVING if movable else OF_DEVICES
        states = [name for name in self._places if unnumbered(name).endswith(first)]
        while True:
            weights = self._weights(states)
            large, small = np.abs(self._answers(ONE * np.array([weights, LESS * weights]), states))
            rows = zip(self._places, (small > large * LESS**1.5).tolist(), strict=False)
            found = {*states, *(name for name, answers in rows if answers)}
            if len(found) == len(states):
                return states
            states = [name for name in self._places if name in found]

    def _found_places(self) -> dict[str, int]:
        """Return where a state may be: at numbers that do not follow from others."""
        marks = [0.5 + number for number in range(len(self._numbers))]
        left = numbers_in(self._end.followed(planted(self._rest, iter(marks))))
        rows = enumerate(zip(named(self._rest), self._numbers, marks, left, strict=True))
        return {
            ".".join([self._end.name, *map(str, names)]): place
            for place, (names, value, mark, found) in rows
            if names[-1] not in WATCHING and math.isfinite(value) and found == mark
        }


def _signals(slot: Slot, values: Signals) -> list[Signal]:
    """Return the numbers of a packet: of wave, position and extra signals."""
    return [(slot, number) for number in range(sum(map(len, values)))]


def placed(states: Iterable[str]) -> Flags:
    """Tell of every state whether it is one that gives a rigid motion ``(n,)``."""
    return np.array([unnumbered(name).endswith(PLACED) for name in states], dtype=np.bool_)


def unnumbered(name: str) -> str:
    """Return the name of a state without axes and other numbers."""
    return re.sub(r"\.\d+", "", name)


def named(value: Any, names: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield the names of all numbers in nested tuples."""
    if isinstance(value, float):
        yield names
    elif isinstance(value, tuple | list):
        for part, name in zip(value, getattr(value, "_fields", range(len(value))), strict=True):
            yield from named(part, (*names, name))


def numbers_in(value: Sequence[Any]) -> list[float]:
    """Return all numbers in nested tuples."""
    found: list[float] = []
    for part in value:
        if isinstance(part, float):
            found.append(part)
        elif isinstance(part, (tuple, list)):
            found += numbers_in(part)
    return found


def planted(value: Any, numbers: Iterator[float]) -> Any:
    """Return nested tuples with other numbers, and lists of their own, which laws may write to."""
    parts = [
        next(numbers) if isinstance(part, float)
        else planted(part, numbers) if isinstance(part, (tuple, list)) else part
        for part in value
    ]  # fmt: skip
    return parts if isinstance(value, list) else tuple.__new__(type(value), parts)
