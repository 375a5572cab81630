# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the one place that knows both the wave controller and its rivals."""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from pmwvc_core.errors import ParameterError
from pmwvc_core.master.controller import MasterController
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.params import BaselineParams, ContactParams, MasterParams, ServerParams
from pmwvc_core.rivals import (
    DirectMaster,
    DirectServer,
    PspmMaster,
    PspmServer,
    TdpaMaster,
    TdpaServer,
    VirtualCouplingMaster,
    VirtualCouplingServer,
)
from pmwvc_core.server.blackbox.containment import Call, directly
from pmwvc_core.server.blackbox.interface import EnvironmentSetup
from pmwvc_core.server.blackbox.plugins import make_black_box
from pmwvc_core.server.factory import make_seats
from pmwvc_core.server.port import WaveServer
from pmwvc_core.server.seats import AS_PUBLISHED, Seat, ServerController
from pmwvc_core.server.unknown import UnknownServer
from pmwvc_core.wave.impedance import Impedance

__all__ = [
    "MASTERS",
    "SERVERS",
    "MasterController",
    "ServerController",
    "make_master",
    "make_server",
]

Maker = TypeVar("Maker")
MASTERS: Mapping[str, Callable[[MasterParams, BaselineParams], MasterController]] = {
    "pmwvc": lambda params, _: WaveMaster(params),
    "direct": lambda params, _: DirectMaster(tick_s=params.tick_s),
    "virtual_coupling": lambda params, baseline: VirtualCouplingMaster(
        baseline.virtual_coupling, tick_s=params.tick_s
    ),
    "tdpa": lambda params, baseline: TdpaMaster(baseline.tdpa, tick_s=params.tick_s),
    "pspm": lambda params, baseline: PspmMaster(baseline.pspm, tick_s=params.tick_s),
}
SERVERS: Mapping[str, Callable[[ServerParams, Sequence[Seat]], ServerController]] = {
    "pmwvc": WaveServer,
    "direct": DirectServer,
    "virtual_coupling": VirtualCouplingServer,
    "tdpa": TdpaServer,
    "pspm": PspmServer,
}


def make_master(
    controller: str, params: MasterParams, baseline: BaselineParams = AS_PUBLISHED
) -> MasterController:
    """Return the master's end of a controller by name, at rest.

    Raises
    ------
    ParameterError
        Naming the controllers there are.
    """
    return _known(controller, MASTERS)(params, baseline)


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
    """Return the server's end of a controller by name, with nobody seated.

    Parameters
    ----------
    controller
        A name in ``SERVERS``.
    server
        The environment and its coupling.
    contacts
        One per user.
    impedances
        Wave impedance of each user's master [N s/m]: used where the contact names none of its own.
    dof
        Number of axes.
    sides
        -1 (left of the object) or +1 (right), one per user.
    baselines
        What other controllers than waves share between their ends, one per user.
    call
        How an unknown environment is asked; directly by default.

    Raises
    ------
    ParameterError
        Naming the controllers there are, or where the numbers of users differ; of an unknown
        environment, why it cannot be used.
    """
    make = _known(controller, SERVERS)
    seats = make_seats(server, contacts, impedances, dof=dof, sides=sides, baselines=baselines)
    if controller == "pmwvc" and server.coupling == "unknown":
        setup = EnvironmentSetup(dof, server.period_s, tuple(sides), server, tuple(contacts))
        return UnknownServer(server, seats, make_black_box(setup), call=call)
    return make(server, seats)


def _known(controller: str, makers: Mapping[str, Maker]) -> Maker:
    if controller not in makers:
        raise ParameterError(f"controller = {controller!r}: must be one of {', '.join(makers)}")
    return makers[controller]
