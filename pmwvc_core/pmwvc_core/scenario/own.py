# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that installed plug-ins declare: one group each, by the plug-in's name.

A controller names a dataclass as ``params`` of its record: every user has its own values,
``lab.gain`` and ``user2.lab.gain``. An environment's factory names one as its attribute
``params``: the values are the session's. The fields are declared by
:func:`pmwvc_core.params.fields.parameter`, like those of the library.
"""

import dataclasses
from collections.abc import Iterator

from pmwvc_core.controllers.library import RECORDS
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params.fields import group
from pmwvc_core.server import environments


def _of_controllers() -> Iterator[tuple[str, type | None]]:
    for name in RECORDS.installed():
        try:
            yield name, RECORDS.of(name).params
        except PmwvcError:  # whoever asks for that controller is told why
            continue


def _of_environments() -> Iterator[tuple[str, type | None]]:
    for name in environments.PLUGINS.installed():
        try:
            yield name, getattr(environments.PLUGINS.load(name), "params", None)
        except PmwvcError:  # likewise
            continue


def _gathered(name: str, found: Iterator[tuple[str, type | None]]) -> type:
    fields = [(one, kind, group(kind)) for one, kind in found if kind is not None]
    here = {"__module__": __name__}  # where another process finds it
    return dataclasses.make_dataclass(name, fields, frozen=True, namespace=here)


ControllerOwn = _gathered("ControllerOwn", _of_controllers())
EnvironmentOwn = _gathered("EnvironmentOwn", _of_environments())
