# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact laws and ports of users, made from parameters."""

from collections.abc import Sequence

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Value
from pmwvc_core.params import BaselineParams, ContactParams, ServerParams
from pmwvc_core.server.contacts import Bilateral, Contact
from pmwvc_core.server.coupled_axes import CoupledBilateral, CoupledGrip
from pmwvc_core.server.friction import AnchoredGrip
from pmwvc_core.server.grip import Grip
from pmwvc_core.server.user_ports import DEFAULT_BASELINE, UserPort
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, impedance_of


def make_contact(
    params: ContactParams, *, side: int, size: Value, dof: int, coupled: bool = False
) -> Contact:
    """Return the contact law ``params.contact`` names.

    Parameters
    ----------
    side : int
        -1: the user stands left of the object and pushes towards +x; +1: right.
    size : Value
        Edge length of the object along axis 0 [m].
    coupled : bool
        Whether the impedance of the wave port couples the axes.
    """
    if side not in (-1, 1):
        raise ParameterError(f"side = {side}: must be -1 (left of the object) or +1 (right)")
    stiffness, damping = params.contact_stiffness, params.contact_damping
    if not params.grips:
        return (CoupledBilateral if coupled else Bilateral)(stiffness, damping)
    grip = Grip(stiffness, damping, side=side, size=size, gap=params.gap_m)
    if dof == 1:
        return grip
    return (CoupledGrip if coupled else AnchoredGrip)(grip, dof=dof)


def make_ports(
    server: ServerParams,
    contacts: Sequence[ContactParams],
    impedances: Sequence[Impedance],
    *,
    dof: int,
    sides: Sequence[int],
    baselines: Sequence[BaselineParams] = (),
) -> list[UserPort]:
    """Return a free port per user; a contact's own impedance goes before ``impedances``."""
    each = baselines or [DEFAULT_BASELINE] * len(contacts)
    if not len(contacts) == len(impedances) == len(sides) == len(each):
        raise ParameterError(
            f"{len(contacts)} contacts, {len(impedances)} impedances, {len(sides)} sides, "
            f"{len(each)} baselines: there must be one of each per user"
        )
    ports = []
    for contact, given, side, baseline in zip(contacts, impedances, sides, each, strict=True):
        own = impedance_of(contact)
        impedance = given if own is None else own
        coupled = isinstance(impedance, MatrixImpedance)
        law = make_contact(contact, side=side, size=server.object_size_m, dof=dof, coupled=coupled)
        ports.append(UserPort(impedance, law, baseline))
    return ports
