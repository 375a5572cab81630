# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that other programs publish on a session's topics: mutations of recorded ones."""

import copy
from collections.abc import Sequence
from random import Random
from typing import Any

import numpy as np

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import RawMessage

STORE = schemas.typestore()
NUMBERS = {"number": ("seq", "step", "first", "first_tick"), "clock": ("start_ns", "sent_ns")}
STRANGER = 0xBAD  # epoch of another publisher


def decoded(message: RawMessage) -> Any:
    return STORE.deserialize_cdr(message.data, message.type_name)


def encoded(message: RawMessage, content: Any) -> RawMessage:
    return message._replace(data=bytes(STORE.serialize_cdr(content, message.type_name)))


def arrays_of(content: Any) -> list[str]:
    return [n for n, value in vars(content).items() if isinstance(value, np.ndarray)]


def other_lengths(message: RawMessage, name: str | None, length: int) -> RawMessage:
    """Give one array (all, without a name) another length."""
    content = copy.deepcopy(decoded(message))
    for field in [name] if name else arrays_of(content):
        setattr(content, field, np.resize(getattr(content, field), length))
    return encoded(message, content)


def of_stranger(message: RawMessage, scale: float = 3.0) -> RawMessage:
    """Return what another publisher would send: whole, plausible, and wrong."""
    content = copy.deepcopy(decoded(message))
    content.epoch = STRANGER
    for field in arrays_of(content):
        values = getattr(content, field)
        if values.dtype == np.float64:
            setattr(content, field, scale * values + 1.0)
    return encoded(message, content)


def with_value(message: RawMessage, name: str, value: float) -> RawMessage:
    """Put one value into a field, into the first entry of an array."""
    content = copy.deepcopy(decoded(message))
    held = getattr(content, name)
    if isinstance(held, np.ndarray):
        changed = held.copy()
        changed[:1] = np.array(value).astype(held.dtype)
        setattr(content, name, changed)
    else:
        setattr(content, name, type(held)(value))
    return encoded(message, content)


def mutated(draw: Random, messages: Sequence[RawMessage]) -> RawMessage:
    """Return one message of a recording, changed in one way."""
    message = draw.choice(messages)
    content = decoded(message)
    arrays = arrays_of(content)
    kind = draw.choice("lengths cut swapped number clock value stranger twice".split())
    if kind == "cut":
        return message._replace(data=message.data[: draw.randrange(len(message.data))])
    if kind == "swapped":
        return message._replace(data=draw.choice(messages).data)
    if kind == "lengths" and arrays:
        return other_lengths(message, draw.choice([None, *arrays]), draw.randrange(40))
    if kind == "stranger" and isinstance(getattr(content, "epoch", None), int):
        return of_stranger(message, draw.uniform(-1e6, 1e6))
    if kind in NUMBERS:
        names = [n for n in NUMBERS[kind] if isinstance(getattr(content, n, None), int)]
        if names:
            name = draw.choice(names)
            bits = 32 if name == "seq" else 63
            return with_value(message, name, draw.randrange(2**bits))
    if kind == "value":
        names = [n for n, held in vars(content).items() if isinstance(held, float)]
        names = [n for n in names if n not in ("lateness", "compute")]  # float32
        names += [n for n in arrays if getattr(content, n).dtype == np.float64]
        if names:
            worst = draw.choice([np.nan, np.inf, -np.inf, 1e300, -1e-300])
            return with_value(message, draw.choice(names), worst)
    return message
