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
MESSAGES_HZ = 500.0  # messages of a page: its mean rate, and as many at once
LIMITS = {  # as the session message declares them
    "heartbeat_s": HEARTBEAT_S, "silence_s": SILENCE_S, "credits": CREDITS,
    "message_bytes": MESSAGE_BYTES, "messages_hz": MESSAGES_HZ,
}  # fmt: skip
LONGEST_NAME = 64
Setting = float | str | bool


class ProtocolError(PmwvcError):
    """A message of a page that does not follow the protocol; the text names what is wrong."""


class Request(NamedTuple):
    """A message of a page: its kind, and the values of its fields, which were checked. It is
    answered with its ``id``; None where no answer is wanted.
    """

    kind: str
    values: Mapping[str, Any]
    id: int | None = None


def _must(value: Any, be: str, *, ok: bool) -> Any:
    if not ok:
        raise ProtocolError(f"must be {be}")
    return value


def _number(value: Any) -> float:  # a flag is an int for Python, and for no page
    ok = type(value) in (int, float) and abs(value) <= sys.float_info.max
    return float(_must(value, "a finite number", ok=ok))


def _count(value: Any) -> Any:
    return _must(value, "a whole number >= 0", ok=type(value) is int and 0 <= value < 2**53)


def _name(value: Any) -> Any:
    ok = isinstance(value, str) and 0 < len(value) <= LONGEST_NAME
    return _must(value, f"a string of 1..{LONGEST_NAME} characters", ok=ok)


def _flag(value: Any) -> Any:
    return _must(value, "true or false", ok=isinstance(value, bool))


def _setting(value: Any) -> Any:
    if isinstance(value, bool):
        return value
    return _name(value) if isinstance(value, str) else _number(value)


def _settings(value: Any) -> dict[str, Setting]:
    ok = isinstance(value, dict) and len(value) <= 32
    given = _must(value, "an object of at most 32 settings", ok=ok)
    return {_name(name): _setting(setting) for name, setting in given.items()}


def _position(value: Any) -> tuple[float, ...] | None:
    ok = value is None or (isinstance(value, list) and 1 <= len(value) <= 6)
    given = _must(value, "a list of 1..6 numbers, or null", ok=ok)
    return None if given is None else tuple(map(_number, given))


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
_CHECKS: Mapping[str, Callable[[Any], Any]] = {  # by the name of a field
    "id": _count, "user": _name, "position": _position, "path": _name, "value": _setting,
    "values": _settings, "paused": _flag, "seq": _count,
}  # fmt: skip


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
        try:
            values[name] = _CHECKS[name](found.pop(name))
        except ProtocolError as error:
            raise ProtocolError(f"{kind}.{name}: {error}") from None
    if found:
        raise ProtocolError(f"{kind}: unknown field {sorted(found)[0][:LONGEST_NAME]!r}")
    return Request(kind, values, values.pop("id", None))
