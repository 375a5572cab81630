# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the library, and entry points of the group ``pmwvc.controllers``.

A laboratory adds a controller by installing a package of its own that names a record
(:class:`.record.Controller`) in that group; nothing here changes.
"""

from collections.abc import Mapping
from functools import cache

from pmwvc_core.controllers import direct, pspm, tdpa, virtual_coupling, waves
from pmwvc_core.controllers.record import Controller
from pmwvc_core.errors import ParameterError
from pmwvc_core.plugins import PluginGroup

LIBRARY: Mapping[str, Controller] = {
    one.RECORD.name: one.RECORD for one in (waves, direct, virtual_coupling, tdpa, pspm)
}
PLUGINS = PluginGroup(
    "pmwvc.controllers", "controller", "a controller", calls=(), own=tuple(LIBRARY)
)


def installed() -> tuple[str, ...]:
    """Return the names of controllers from other packages, without importing any."""
    return tuple(name for name in PLUGINS.installed() if name not in LIBRARY)


def names() -> tuple[str, ...]:
    """Return every name that a scenario may give, those of the library first."""
    return (*LIBRARY, *installed())


def record_of(controller: str) -> Controller:
    """Return a controller by name.

    Raises
    ------
    ParameterError
        If there is none of this name (naming those there are), if a plug-in cannot be imported
        (with the reason), or if its entry point names no controller.
    """
    return LIBRARY[controller] if controller in LIBRARY else plugin(controller)


def has_waves(controller: str) -> bool:
    """Tell whether a controller, by name, joins its ends by wave variables."""
    return record_of(controller).waves


def proofs_hold(controller: str) -> bool:
    """Tell whether the proofs of wave ports (docs/theory.md) hold for a controller, by name: it
    has waves, and the linear model of waves is its own.
    """
    record = record_of(controller)
    return record.waves and record.linear == record.name


@cache
def plugin(controller: str) -> Controller:
    """Return a controller of another package; what raises is asked again the next time."""
    if controller not in PLUGINS.installed():
        raise ParameterError(
            f"controller = {controller!r}: must be one of {', '.join(names())}. A plug-in is a "
            f"package with an entry point in the group {PLUGINS.group!r}"
        )
    record = PLUGINS.load(controller)
    where = PLUGINS.where(controller)
    if not isinstance(record, Controller):
        raise ParameterError(
            f"{where} is not a controller: it is a {type(record).__name__}, must be a record "
            "pmwvc_core.controllers.Controller"
        )
    if record.name != controller:
        raise ParameterError(f"{where} has another name: {record.name!r}")
    if record.linear is not None and record.linear not in LIBRARY:
        raise ParameterError(
            f"{where}: linear = {record.linear!r}: must be None or one of {', '.join(LIBRARY)}"
        )
    return record
