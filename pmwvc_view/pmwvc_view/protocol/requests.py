# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of a page, read from its messages and checked."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from pmwvc_core.errors import PmwvcError

LONGEST_NAME = 64
Setting = float | str | bool


class ProtocolError(PmwvcError):
    """A message of a page that does not follow the protocol; the text names what is wrong."""


@dataclass(frozen=True)
class Request:
    """A message of a page."""

    kind: ClassVar[str] = ""


@dataclass(frozen=True)
class Answered(Request):
    """A request that is answered with its ``id``; None where no answer is wanted."""

    id: int | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Take(Answered):
    """Take hold of a user's handle."""

    kind: ClassVar[str] = "take"
    user: str


@dataclass(frozen=True)
class LetGo(Answered):
    """Let go of a user's handle, and free it for others."""

    kind: ClassVar[str] = "let_go"
    user: str


@dataclass(frozen=True)
class Target(Request):
    """The newest target of a hand [m], one value per axis; None: held no longer, place kept."""

    kind: ClassVar[str] = "target"
    user: str
    position: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Set(Answered):
    """Change a parameter of the running session."""

    kind: ClassVar[str] = "set"
    path: str
    value: Setting


@dataclass(frozen=True)
class Ask(Answered):
    """Ask what the exact model says of these settings."""

    kind: ClassVar[str] = "ask"
    values: Mapping[str, Setting]


@dataclass(frozen=True)
class Pause(Answered):
    """Let time stand still, or go on."""

    kind: ClassVar[str] = "pause"
    paused: bool


@dataclass(frozen=True)
class Restart(Answered):
    """Begin again from the start, with these settings changed."""

    kind: ClassVar[str] = "restart"
    values: Mapping[str, Setting]


@dataclass(frozen=True)
class Seek(Answered):
    """Go to a time of a recorded session [s]."""

    kind: ClassVar[str] = "seek"
    time_s: float


@dataclass(frozen=True)
class Speed(Answered):
    """Play a recorded session at this ratio of its speed."""

    kind: ClassVar[str] = "speed"
    ratio: float


@dataclass(frozen=True)
class Seen(Request):
    """Acknowledge all snapshots up to this number."""

    kind: ClassVar[str] = "seen"
    seq: int


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


_KINDS = (Take, LetGo, Target, Set, Ask, Pause, Restart, Seek, Speed, Seen)
_REQUESTS: dict[str, type[Request]] = {each.kind: each for each in _KINDS}
_FIELDS = {each.kind: tuple(field.name for field in fields(each)) for each in _KINDS}
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
    request = _REQUESTS.get(found.pop("kind"))
    if request is None:
        raise ProtocolError(f"kind: must be one of {', '.join(_REQUESTS)}")
    values: dict[str, Any] = {}
    for name in _FIELDS[request.kind]:
        if name not in found:
            if name != "id":
                raise ProtocolError(f"{request.kind}.{name} is missing")
            continue
        try:
            values[name] = _CHECKS[name](found.pop(name))
        except ProtocolError as error:
            raise ProtocolError(f"{request.kind}.{name}: {error}") from None
    if found:
        raise ProtocolError(f"{request.kind}: unknown field {sorted(found)[0][:LONGEST_NAME]!r}")
    return request(**values)
