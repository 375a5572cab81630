# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The health of a node as a diagnostic message."""

from collections.abc import Mapping
from typing import Any

from pmwvc_core.runtime.messages.types import MessageTypes, time_message


def diagnostic(
    types: MessageTypes,
    *,
    stamp_ns: int,
    name: str,
    level: int,
    message: str,
    values: Mapping[str, object],
) -> Any:
    """Return the health of one node as a DiagnosticArray (level 0 fine, 1 warning, 2 error)."""
    status = types.DiagnosticStatus(
        level=types.octet(level),
        name=name,
        message=message,
        hardware_id="",
        values=[types.KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
    header = types.Header(stamp=time_message(types, stamp_ns), frame_id="")
    return types.DiagnosticArray(header=header, status=[status])
