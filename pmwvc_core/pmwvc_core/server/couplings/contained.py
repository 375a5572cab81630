# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The containment of plug-in couplings: a step that fails is a matched damper at every port.

What the failed step changed is taken back. Then f_s = sqrt(b/2) u_s, so that no wave returns;
avatars and object move by these forces as the record says that they move. Heat is what went in
and is not stored. Not here: a step that takes too long, and what a solver keeps outside its
ports.
"""

from collections.abc import Sequence
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS, ParameterError
from pmwvc_core.numeric import Value, dot
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import refused
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.couplings.library import COUPLINGS
from pmwvc_core.server.couplings.record import Coupling, Faulting, LoopSolver, backward
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


def solver_of(record: Coupling, params: ServerParams) -> LoopSolver:
    """Return the solver of a coupling, that of a plug-in contained.

    Raises
    ------
    ParameterError
        If the coupling is for black boxes, or a plug-in cannot make its solver (with the reason).
    """
    if record.make is None:
        raise ParameterError(
            f"server.coupling = {record.name!r}: is for black boxes; a wave server knows "
            "its environment"
        )
    if record.name in COUPLINGS.library:
        return record.make(params)
    with refused(f"server.coupling = {record.name!r}"):
        return Contained(record.make(params), record, params)


class Contained:
    """The solver of a plug-in, with a damper for the steps that it fails."""

    def __init__(self, solver: LoopSolver, record: Coupling, params: ServerParams) -> None:
        own = solver.faults if isinstance(solver, Faulting) else None
        self.faults = own or Faults("server.coupling", record.name)
        self._solver = solver
        self._record = record
        self._period = params.period_s
        self._old, self._new = (record.moves or backward)(params)

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """Use every port's ``u_s``; return the energy dissipated [J]."""
        blocks: list[Any] = [body, *(port.contact for port in ports)]
        states = [block.snapshot() for block in blocks]
        signals = [(port.xd_s, port.f_s, dict(port.kept)) for port in ports]
        try:
            return self._solver.step(ports, body)
        except PLUGIN_ERRORS as error:  # whatever a plug-in raises
            self.faults.note(error)
            self.faults.replaced = True
        for block, state in zip(blocks, states, strict=True):
            block.restore(state)
        for port, (velocity, force, kept) in zip(ports, signals, strict=True):
            port.xd_s, port.f_s, port.kept = velocity, force, kept
        return self._damped(ports, body)

    def _damped(self, ports: Sequence[UserPort], body: Body) -> Value:
        before = _stored(ports, body)
        held: Value = 0.0
        force: Value = 0.0
        into: Value = 0.0
        ways = []
        for port in ports:
            damped = 0.5 * port.wave.free_velocity(port.u_s)
            push = port.b * damped
            late = self._record.late
            velocity = port.wave.velocity(port.u_s, port.f_s) if late else damped
            ways.append(self._old * port.xd_s + self._new * velocity)
            held, force = held + port.f_s, force + push
            into = into + self._period * dot(push, velocity)
            port.xd_s, port.f_s = velocity, push
        moved = self._moved(body, held, force)
        for port, way in zip(ports, ways, strict=True):
            port.contact.slide(way - moved)
        return into - (_stored(ports, body) - before)

    def _moved(self, body: Body, held: Value, force: Value) -> Value:
        """Move the object; return its displacement [m]."""
        if self._record.object_motion == "midpoint":
            velocity = body.xd - body.imbalance(body.xd, force) * body.mobility(0.0 * force)
            body.drift(velocity)
            return self._period * velocity
        return body.push(held if self._record.object_motion == "held_before" else force)[0]


def _stored(ports: Sequence[UserPort], body: Body) -> Value:
    energy = body.kinetic
    for port in ports:
        energy = energy + port.contact.energy
    return energy
