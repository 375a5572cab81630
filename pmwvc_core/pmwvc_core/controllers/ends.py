# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a controller, made by its name."""

from collections.abc import Sequence

from pmwvc_core.controllers.library import record_of
from pmwvc_core.errors import ParameterError
from pmwvc_core.master.brake import HandBrake
from pmwvc_core.master.controller import MasterController
from pmwvc_core.params import BaselineParams, ContactParams, MasterParams, ServerParams
from pmwvc_core.server.black_box.containment import Call, directly
from pmwvc_core.server.black_box.interface import EnvironmentSetup
from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.environments import make_black_box
from pmwvc_core.server.factory import make_ports
from pmwvc_core.server.user_ports import DEFAULT_BASELINE
from pmwvc_core.transport.packet import Packer
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.playout import Playout


def make_master(
    controller: str,
    params: MasterParams,
    baseline: BaselineParams = DEFAULT_BASELINE,
    *,
    strict: tuple[Playout, Packer, HandBrake] | None = None,
) -> MasterController:
    """Return the master's end of a controller by name, at rest.

    Parameters
    ----------
    params, baseline
        Of the master, and of other controllers than waves.
    strict
        On the strict channel: playout of the returning wave, sender of the outgoing one, brake.

    Raises
    ------
    ParameterError
        Naming the controllers there are.
    """
    record = record_of(controller)
    if strict is not None and record.make_strict is not None:
        return record.make_strict(params, *strict)
    return record.make_master(params, baseline)


def make_server(
    controller: str,
    server: ServerParams,
    contacts: Sequence[ContactParams],
    impedances: Sequence[Impedance],
    *,
    dof: int,
    sides: Sequence[int],
    baselines: Sequence[BaselineParams] = (),
    call: Call = directly,
) -> ServerController:
    """Return the server's end of a controller by name, with no user present.

    Parameters
    ----------
    server
        The environment and its coupling.
    contacts, impedances
        One per user; wave impedance of the master [N s/m]: used where the contact names none.
    dof, sides
        Number of axes; -1 (left of the object) or +1 (right), one per user.
    baselines
        What other controllers than waves share between their ends, one per user.
    call
        How a black box is asked; directly by default.

    Raises
    ------
    ParameterError
        Naming the controllers there are, or where the numbers of users differ; of a
        black box, why it cannot be used.
    """
    record = record_of(controller)
    ports = make_ports(server, contacts, impedances, dof=dof, sides=sides, baselines=baselines)
    coupling = record.coupling or COUPLINGS.of(server.coupling)
    if not coupling.black_box:
        return record.make_server(server, ports)
    if record.make_black_box is None:
        raise ParameterError(
            f"server.coupling = {coupling.name!r}: controller = {controller} has no port for it"
        )
    setup = EnvironmentSetup(dof, server.period_s, tuple(sides), server, tuple(contacts))
    return record.make_black_box(server, ports, make_black_box(setup), call)
