# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that installed plug-ins declare: one group each, by the plug-in's name.

A controller names a dataclass as ``params`` of its record: every user has its own values,
``lab.gain`` and ``user2.lab.gain``. An environment's factory names one as its attribute
``params``: the values are the session's. The fields are declared by
:func:`pmwvc_core.params.fields.parameter`, like those of the library.
"""

import contextlib
import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

from pmwvc_core.controllers.library import RECORDS
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params.fields import group
from pmwvc_core.plugins import installed
from pmwvc_core.server.environments import PLUGINS


def _gathered(name: str, plugins: Iterable[str], load: Callable[[str], Any]) -> type:
    fields = []
    for one in plugins:
        with contextlib.suppress(PmwvcError):  # whoever asks for that plug-in is told why
            kind = getattr(load(one), "params", None)
            if kind is not None:
                fields.append((one, kind, group(kind)))
    here = {"__module__": __name__}  # where another process finds it
    return dataclasses.make_dataclass(name, fields, frozen=True, namespace=here)


ControllerOwn = _gathered("ControllerOwn", RECORDS.installed(), RECORDS.of)
EnvironmentOwn = _gathered("EnvironmentOwn", installed(PLUGINS.group), PLUGINS.load)
