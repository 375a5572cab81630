# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the energies mean that both ends count, by name and in their order."""

from pmwvc_core.account import Entry
from pmwvc_core.controllers.library import is_strict, record_of
from pmwvc_core.made.without_waves import CONTROLLERS
from pmwvc_core.master.port_filters.filter_bank import ENTRIES as OF_BANK
from pmwvc_core.master.port_filters.local_model import ENTRIES as OF_LOCAL_MODEL
from pmwvc_core.master.port_filters.velocity_filter import IN_FORCE, IN_WAVE
from pmwvc_core.master.position.feedback import ENTRIES as OF_POSITION
from pmwvc_core.master.strict_accounts import DISCARDED, FREE, GIVEN, NODE, RELEASED
from pmwvc_core.params import MasterParams, ServerParams
from pmwvc_core.server.avatar_brake import ENTRIES as OF_BRAKES
from pmwvc_core.server.black_box.accounts import ENTRIES as OF_BLACK_BOX
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.couplings import COUPLINGS

OF_STRICT = (NODE, GIVEN, RELEASED, FREE, DISCARDED)


def accounts_of_user(controller: str, channel: str, master: MasterParams) -> tuple[Entry, ...]:
    """Return the accounts of a user's port behind the energies of any port."""
    if controller in CONTROLLERS:
        return record_of(controller).accounts
    strict = is_strict(controller, channel)
    velocity, position = master.velocity_filter, master.position
    found = list(OF_STRICT if strict else ())
    if velocity.is_on and not velocity.in_force:
        found.append(IN_WAVE)
    if master.bank.is_on:
        found += OF_BANK + OF_LOCAL_MODEL
    if velocity.is_on and velocity.in_force:
        found.append(IN_FORCE)
    if position.is_on:
        lent = strict or position.as_published
        found += OF_POSITION[:1] if lent else OF_POSITION
    return tuple(found)


def accounts_of_server(controller: str, channel: str, server: ServerParams) -> tuple[Entry, ...]:
    """Return the accounts of the environment."""
    if controller in CONTROLLERS:
        return record_of(controller).accounts
    found: tuple[Entry, ...] = ()
    if COUPLINGS.of(server.coupling).black_box:
        found = OF_BLACK_BOX + COMPENSATIONS.of(server.compensation).accounts
    return found + OF_BRAKES if is_strict(controller, channel) else found
