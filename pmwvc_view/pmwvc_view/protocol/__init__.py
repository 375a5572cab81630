# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The protocol between the page and its server: its numbers, and the requests of a page, read from
its messages and checked. Its document, which the page follows, is docs/view_protocol.md. No input
or output here.
"""

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_core.errors import PmwvcError

VERSION = 1
HEARTBEAT_S = 0.014  # a held target is sent this often, also where it does not move
SILENCE_S = 0.15  # a hand without a target for this long lets go
CREDITS = 8  # snapshots that may be sent and not acknowledged
MESSAGE_BYTES = 4096  # longest message of a page
MESSAGES_HZ = 500.0  # messages of a page in a second
LONGEST_NAME = 64


class ProtocolError(PmwvcError):
    """A message of a page that does not follow the protocol; the text names what is wrong."""


class Request(NamedTuple):
    """A message of a page: its kind, and the values of its fields, which were checked. It is
    answered with its ``id``; None where no answer is wanted.
    """

    kind: str
    values: Mapping[str, Any]
    id: int | None = None


def _is_number(value: Any) -> bool:  # a flag is an int for Python, and for no page
    return type(value) in (int, float) and abs(value) <= sys.float_info.max


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_NAME


def _is_setting(value: Any) -> bool:
    return isinstance(value, bool) or _is_name(value) or _is_number(value)


def _are_settings(value: Any) -> bool:
    pairs = value.items() if isinstance(value, dict) and len(value) <= 32 else [("", None)]
    return all(_is_name(name) and _is_setting(each) for name, each in pairs)


def _is_position(value: Any) -> bool:
    ok = isinstance(value, list) and 1 <= len(value) <= 6 and all(map(_is_number, value))
    return value is None or ok


_FIELDS: Mapping[str, tuple[str, ...]] = {  # of each kind of request
    "take": ("id", "user"),  # take hold of a user's handle
    "let_go": ("id", "user"),  # let go of it, and free it for others
    "target": ("user", "position"),  # newest of a hand [m], per axis; None: held no longer, kept
    "set": ("id", "path", "value"),  # change a parameter of the running session
    "ask": ("id", "values"),  # what the exact model says of these settings
    "pause": ("id", "paused"),  # let time stand still, or go on
    "restart": ("id", "values"),  # begin again from the start, with these settings changed
    "seen": ("seq",),  # acknowledge all snapshots up to this number
}
_NAME = _is_name, f"a string of 1..{LONGEST_NAME} characters"
_COUNT = lambda value: type(value) is int and 0 <= value < 2**53, "a whole number >= 0"
_CHECKS: Mapping[str, tuple[Callable[[Any], bool], str]] = {  # by the name of a field
    "id": _COUNT,
    "seq": _COUNT,
    "user": _NAME,
    "path": _NAME,
    "paused": (lambda value: isinstance(value, bool), "true or false"),
    "value": (_is_setting, f"a finite number, a flag or {_NAME[1]}"),
    "values": (_are_settings, "an object of at most 32 settings: numbers, flags and names"),
    "position": (_is_position, "a list of 1..6 finite numbers, or null"),
}


def read(text: str) -> Request:
    """Return the request that a message of a page holds; ProtocolError with what is wrong."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        raise ProtocolError("a message must be JSON") from None
    if not isinstance(found, dict) or not isinstance(found.get("kind"), str):
        raise ProtocolError("a message must be an object with a string named kind")
    kind = found.pop("kind")
    if kind not in _FIELDS:
        raise ProtocolError(f"kind: must be one of {', '.join(_FIELDS)}")
    values: dict[str, Any] = {}
    for name in _FIELDS[kind]:
        if name not in found:
            if name != "id":
                raise ProtocolError(f"{kind}.{name} is missing")
            continue
        values[name], (ok, words) = found.pop(name), _CHECKS[name]
        if not ok(values[name]):
            raise ProtocolError(f"{kind}.{name}: must be {words}")
    if found:
        raise ProtocolError(f"{kind}: unknown field {sorted(found)[0][:LONGEST_NAME]!r}")
    return Request(kind, values, values.pop("id", None))
