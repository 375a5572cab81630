# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the energies mean that both ends count, by name and in their order."""

from pmwvc_core.account import Entry
from pmwvc_core.controllers.accounts import (
    BRAKES,
    FORCE_FILTER,
    OF_BANK,
    OF_BLACK_BOX,
    OF_POSITION,
    OF_STRICT,
    VELOCITY_FILTER,
)
from pmwvc_core.controllers.library import is_strict, record_of
from pmwvc_core.params import MasterParams, ServerParams
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.couplings import COUPLINGS


def accounts_of_user(controller: str, channel: str, master: MasterParams) -> tuple[Entry, ...]:
    """Return the accounts of a user's port behind the energies of any port."""
    record = record_of(controller)
    if record.device is not None or not record.waves:
        return record.accounts
    strict = is_strict(controller, channel)
    velocity, position = master.velocity_filter, master.position
    found = list(OF_STRICT if strict else ())
    if velocity.is_on and not velocity.in_force:
        found.append(VELOCITY_FILTER)
    if master.bank.is_on:
        found += OF_BANK
    if velocity.is_on and velocity.in_force:
        found.append(FORCE_FILTER)
    if position.is_on:
        lent = strict or position.as_published
        found += OF_POSITION[:1] if lent else OF_POSITION
    return tuple(found)


def accounts_of_server(controller: str, channel: str, server: ServerParams) -> tuple[Entry, ...]:
    """Return the accounts of the environment."""
    record = record_of(controller)
    if record.avatar is not None or not record.waves:
        return record.accounts
    found: tuple[Entry, ...] = ()
    if COUPLINGS.of(server.coupling).black_box:
        found = OF_BLACK_BOX + COMPENSATIONS.of(server.compensation).accounts
    return (*found, BRAKES) if is_strict(controller, channel) else found
