# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of a page, read from its messages and checked."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from pmwvc_core.errors import PmwvcError

LONGEST_NAME = 64


class ProtocolError(PmwvcError):
    """A message of a page that does not follow the protocol; the text names what is wrong."""


@dataclass(frozen=True)
class Request:
    """A message of a page; ``id`` is repeated in the answer, None where none is wanted."""

    kind: ClassVar[str] = ""


@dataclass(frozen=True)
class Take(Request):
    """Take hold of a user's handle."""

    kind: ClassVar[str] = "take"
    user: str
    id: int | None = None


@dataclass(frozen=True)
class LetGo(Request):
    """Let go of a user's handle, and free it for others."""

    kind: ClassVar[str] = "let_go"
    user: str
    id: int | None = None


@dataclass(frozen=True)
class Target(Request):
    """The newest target of a hand [m], one value per axis; None: held no longer, place kept."""

    kind: ClassVar[str] = "target"
    user: str
    position: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Set(Request):
    """Change a parameter of the running session."""

    kind: ClassVar[str] = "set"
    path: str
    value: float | str | bool
    id: int | None = None


@dataclass(frozen=True)
class Ask(Request):
    """Ask what the exact model says of these settings."""

    kind: ClassVar[str] = "ask"
    values: Mapping[str, float | str | bool]
    id: int | None = None


@dataclass(frozen=True)
class Pause(Request):
    """Let time stand still, or go on."""

    kind: ClassVar[str] = "pause"
    paused: bool
    id: int | None = None


@dataclass(frozen=True)
class Restart(Request):
    """Begin again from the start, with these settings changed."""

    kind: ClassVar[str] = "restart"
    values: Mapping[str, float | str | bool]
    id: int | None = None


@dataclass(frozen=True)
class Seek(Request):
    """Go to a time of a recorded session [s]."""

    kind: ClassVar[str] = "seek"
    time_s: float
    id: int | None = None


@dataclass(frozen=True)
class Speed(Request):
    """Play a recorded session at this ratio of its speed."""

    kind: ClassVar[str] = "speed"
    ratio: float
    id: int | None = None


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
        raise ProtocolError(f"must be a text of 1..{LONGEST_NAME} characters")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ProtocolError("must be true or false")
    return value


def _setting(value: Any) -> float | str | bool:
    if isinstance(value, (bool, str)):
        return value if isinstance(value, bool) else _name(value)
    return _number(value)


def _settings(value: Any) -> dict[str, float | str | bool]:
    if not isinstance(value, dict) or len(value) > 32:
        raise ProtocolError("must be an object of at most 32 settings")
    return {_name(name): _setting(setting) for name, setting in value.items()}


def _position(value: Any) -> tuple[float, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not 1 <= len(value) <= 6:
        raise ProtocolError("must be a list of 1..6 numbers, or null")
    return tuple(_number(each) for each in value)


Check = Callable[[Any], Any]
_ID: dict[str, Check] = {"id": _count}
_KINDS: tuple[tuple[type[Request], dict[str, Check], dict[str, Check]], ...] = (
    (Take, {"user": _name}, _ID),
    (LetGo, {"user": _name}, _ID),
    (Target, {"user": _name, "position": _position}, {}),
    (Set, {"path": _name, "value": _setting}, _ID),
    (Ask, {"values": _settings}, _ID),
    (Pause, {"paused": _flag}, _ID),
    (Restart, {"values": _settings}, _ID),
    (Seek, {"time_s": _number}, _ID),
    (Speed, {"ratio": _number}, _ID),
    (Seen, {"seq": _count}, {}),
)
_REQUESTS = {kind.kind: (kind, required, optional) for kind, required, optional in _KINDS}


def read(text: str) -> Request:
    """Return the request that a message of a page holds.

    Raises
    ------
    ProtocolError
        Naming what is wrong.
    """
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        raise ProtocolError("a message must be JSON") from None
    if not isinstance(found, dict) or not isinstance(found.get("kind"), str):
        raise ProtocolError("a message must be an object with a text named kind")
    known = _REQUESTS.get(found.pop("kind"))
    if known is None:
        raise ProtocolError(f"kind: must be one of {', '.join(_REQUESTS)}")
    request, required, optional = known
    values: dict[str, Any] = {}
    for name, check in (required | optional).items():
        if name not in found:
            if name in required:
                raise ProtocolError(f"{request.kind}.{name} is missing")
            continue
        try:
            values[name] = check(found.pop(name))
        except ProtocolError as error:
            raise ProtocolError(f"{request.kind}.{name}: {error}") from None
    if found:
        raise ProtocolError(f"{request.kind}: unknown field {sorted(found)[0][:LONGEST_NAME]!r}")
    return request(**values)
