# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the library, and entry points of the group ``pmwvc.controllers``.

A laboratory adds a controller by installing a package of its own that names a record
(:class:`.record.Controller`) in that group; nothing here changes.
"""

from pmwvc_core.account import Entry
from pmwvc_core.controllers import waves, without_waves
from pmwvc_core.controllers.record import Controller
from pmwvc_core.plugins import Records
from pmwvc_core.server.compensations import COMPENSATIONS

RECORDS: Records[Controller] = Records(
    Controller,
    (waves.RECORD, *without_waves.RECORDS),
    group="pmwvc.controllers",
    parameter="controller",
    what="a controller",
)
STRICT, PLAIN, ZEROING = CHANNELS = ("strict", "plain", "zeroing")
LIBRARY, names, record_of = RECORDS.library, RECORDS.names, RECORDS.of


def entries() -> dict[str, Entry]:
    """Return every account by name that a controller or a compensation keeps: of the library, and
    of those of other packages that were asked for.
    """
    kept = [record.accounts for record in RECORDS.met.values()]
    kept += [record.accounts for record in COMPENSATIONS.met.values()]
    return {entry.name: entry for accounts in kept for entry in accounts}


def has_waves(controller: str) -> bool:
    """Tell whether a controller, by name, joins its ends by wave variables."""
    return record_of(controller).waves


def proofs_hold(controller: str) -> bool:
    """Tell whether the proofs of wave ports (docs/theory.md) hold for a controller, by name: only
    for the library's own.
    """
    return controller in LIBRARY and has_waves(controller)


def is_strict(controller: str, channel: str) -> bool:
    """Tell whether a controller, by name, runs on the strict channel; only the library's
    waves can.
    """
    return channel == STRICT and controller == waves.RECORD.name


def is_zeroing(controller: str, channel: str) -> bool:
    """Tell whether a controller, by name, counts every wave once; only waves can."""
    return channel == ZEROING and has_waves(controller)
