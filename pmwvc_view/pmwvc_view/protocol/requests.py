# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of a page, read from its messages and checked."""

import json
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pmwvc_core.errors import PmwvcError

LONGEST_NAME = 64
Setting = float | str | bool


class ProtocolError(PmwvcError):
    """A message of a page that does not follow the protocol; the text names what is wrong."""


class Request(NamedTuple):
    """A message of a page: its kind, and the values of its fields, which were checked.

    It is answered with its ``id``; None where no answer is wanted.
    """

    kind: str
    values: Mapping[str, Any]
    id: int | None = None


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ProtocolError("must be a finite number")
    return float(value)


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
        raise ProtocolError("must be a whole number >= 0")
    return value


def _name(value: Any) -> str:
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST_NAME:
        raise ProtocolError(f"must be a string of 1..{LONGEST_NAME} characters")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ProtocolError("must be true or false")
    return value


def _setting(value: Any) -> Setting:
    if isinstance(value, (bool, str)):
        return value if isinstance(value, bool) else _name(value)
    return _number(value)


def _settings(value: Any) -> dict[str, Setting]:
    if not isinstance(value, dict) or len(value) > 32:
        raise ProtocolError("must be an object of at most 32 settings")
    return {_name(name): _setting(setting) for name, setting in value.items()}


def _position(value: Any) -> tuple[float, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not 1 <= len(value) <= 6:
        raise ProtocolError("must be a list of 1..6 numbers, or null")
    return tuple(_number(each) for each in value)


_FIELDS: Mapping[str, tuple[str, ...]] = {  # of each kind of request
    "take": ("id", "user"),  # take hold of a user's handle
    "let_go": ("id", "user"),  # let go of it, and free it for others
    "target": ("user", "position"),  # newest of a hand [m], per axis; None: held no longer, kept
    "set": ("id", "path", "value"),  # change a parameter of the running session
    "ask": ("id", "values"),  # what the exact model says of these settings
    "pause": ("id", "paused"),  # let time stand still, or go on
    "restart": ("id", "values"),  # begin again from the start, with these settings changed
    "seek": ("id", "time_s"),  # go to a time of a recorded session [s]
    "speed": ("id", "ratio"),  # play a recorded session at this ratio of its speed
    "seen": ("seq",),  # acknowledge all snapshots up to this number
}
_CHECKS: Mapping[str, Callable[[Any], Any]] = {  # by the name of a field
    "id": _count,
    "user": _name,
    "position": _position,
    "path": _name,
    "value": _setting,
    "values": _settings,
    "paused": _flag,
    "time_s": _number,
    "ratio": _number,
    "seq": _count,
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
        try:
            values[name] = _CHECKS[name](found.pop(name))
        except ProtocolError as error:
            raise ProtocolError(f"{kind}.{name}: {error}") from None
    if found:
        raise ProtocolError(f"{kind}: unknown field {sorted(found)[0][:LONGEST_NAME]!r}")
    return Request(kind, values, values.pop("id", None))
