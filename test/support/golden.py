# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Golden traces: what the sessions of :mod:`support.golden_sessions` gave, kept row by row.

::

    python test/support/golden.py grip_strict_1     # record it anew; says what changed

Kept of each signal: every 50th row and the last, and over all rows sum, sum of squares, number of
values that are not finite and largest magnitude. Texts and counts are kept whole.
"""

import argparse
import dataclasses
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one
from support.golden_sessions import MAPPINGS, SENSITIVE

FOLDER = Path(__file__).resolve().parents[1] / "data" / "golden"
STRIDE = 50
TOLERANCE = 1e-12  # of the largest magnitude of a signal, absolute below 1; but see SENSITIVE
LEFT_OUT = ("metadata", "counts", "epoch", "lateness_s", "compute_s", "looked_ns")


class Signal(NamedTuple):
    """The rows kept of a signal ``(row, columns)``, the number of each, and its sums."""

    row: NDArray[np.int64]
    values: NDArray[np.float64]
    length: int
    sums: NDArray[np.float64]  # sum, sum of squares, not finite, largest magnitude


class Record(NamedTuple):
    """What is kept of a session."""

    signals: dict[str, Signal]
    texts: dict[str, Any]


def _parts(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield arrays, texts and numbers of nested traces by dotted name."""
    if dataclasses.is_dataclass(value):
        value = {each.name: getattr(value, each.name) for each in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        for key, part in value.items():
            if key not in LEFT_OUT:
                yield from _parts(part, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list) and any(map(_is_nested, value)):
        for number, part in enumerate(value, start=1):
            yield from _parts(part, f"{name}.{number}")
    else:
        yield name, value


def _is_nested(value: Any) -> bool:
    return isinstance(value, np.ndarray) or dataclasses.is_dataclass(value)


def _signal(array: NDArray[Any]) -> Signal:
    table = np.asarray(array, dtype=np.float64).reshape(len(array), -1 if array.size else 1)
    row = np.unique(np.append(np.arange(0, len(table), STRIDE), len(table) - 1))
    finite = np.where(np.isfinite(table), table, 0.0)
    lost = np.sum(~np.isfinite(table))
    sums = [finite.sum(), (finite * finite).sum(), lost, np.abs(finite).max(initial=0.0)]
    row = row[row >= 0]
    return Signal(row, table[row], len(table), np.array(sums))


def _runs(texts: list[str]) -> list[tuple[int, str]]:
    """Return the rows at which a list of texts changes."""
    return [(i, t) for i, t in enumerate(texts) if i == 0 or t != texts[i - 1]]


def recorded(name: str) -> Record:
    """Simulate a session and return what is kept of it."""
    return record_of(simulate_one(parse_scenario(MAPPINGS[name])))


def record_of(traces: Any) -> Record:
    """Return what is kept of traces."""
    signals, texts = {}, {}
    for path, value in _parts(traces, ""):
        if isinstance(value, np.ndarray) and value.shape[1:] == (0,):
            continue  # orientations of fewer than six axes
        if isinstance(value, np.ndarray) and value.ndim:
            signals[path] = _signal(value)
        elif path.endswith(".reason"):
            texts[path] = _runs(value)
        else:
            texts[path] = value
    return Record(signals, json.loads(json.dumps(texts, default=_plain)))


def _plain(value: Any) -> Any:
    return np.asarray(value).tolist()


def save(record: Record, file: Path) -> None:
    """Write a record: all numbers as one array, names and lengths as text."""
    signals = record.signals.values()
    shapes = {
        name: [len(each.row), each.values.shape[1], each.length]
        for name, each in record.signals.items()
    }
    parts = [part.ravel() for each in signals for part in (each.values, each.sums)]
    text = json.dumps({"shapes": shapes, "texts": record.texts})
    file.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        file, numbers=np.concatenate(parts), text=np.frombuffer(text.encode(), np.uint8)
    )


def load(file: Path) -> Record:
    """Read a record, as ``load(path).signals["users.1.f_m"].values``."""
    with np.load(file) as data:
        numbers, text = data["numbers"], json.loads(data["text"].tobytes())
    signals, at = {}, 0
    for name, (rows, columns, length) in text["shapes"].items():
        row = np.arange(rows) * STRIDE
        row[-1:] = length - 1
        values = numbers[at : at + rows * columns].reshape(rows, columns)
        at += rows * columns
        signals[name] = Signal(row, values, length, numbers[at : at + 4])
        at += 4
    return Record(signals, text["texts"])


def _by_how_much(
    name: str, was: Signal, now: Signal, tolerance: float
) -> tuple[float, str] | None:
    """Return where a signal first differs, as a part of the session, and the words for it."""
    if was.length != now.length or was.values.shape != now.values.shape:
        return 0.0, f"{name}: {now.values.shape} of {now.length} rows, not {was.length}"
    if not was.length:
        return None
    allowed = tolerance * max(1.0, float(was.sums[3]))
    same = np.isclose(now.values, was.values, rtol=0.0, atol=allowed, equal_nan=True)
    if len(wrong := np.argwhere(~same)):
        i, column = wrong[0]
        off = np.abs(now.values - was.values)
        words = (
            f"{name}: row {was.row[i]} of {was.length}, column {column}: "
            f"{now.values[i, column]!r}, not {was.values[i, column]!r}; by at most "
            f"{np.nanmax(off):.3g} ({allowed:.1g} allowed)"
        )
        return was.row[i] / was.length, words
    several = max(1, was.values.shape[1]) * was.length * allowed  # each value may be that far off
    limits = several * np.array([1.0, 2.0 * max(1.0, float(was.sums[3])), 0.0, 1.0 / was.length])
    off = np.abs(now.sums - was.sums)
    for what, by, limit in zip(
        ("sum", "sum of squares", "not finite", "largest"), off, limits, strict=True
    ):
        if not by <= limit:
            return 1.0, f"{name}: {what} over all rows is off by {by:.3g} ({limit:.1g} allowed)"
    return None


def tolerance_of(name: str) -> float:
    """Return what a session may differ by, as a part of each signal's largest magnitude."""
    return SENSITIVE.get(name, TOLERANCE)


def differences(was: Record, now: Record, tolerance: float = TOLERANCE) -> list[str]:
    """Return in words what differs: signals, the earliest first, then texts and counts."""
    names = [
        f"{name}: {now.texts.get(name)!r}, not {was.texts.get(name)!r}"
        for name in sorted(was.texts.keys() | now.texts.keys())
        if was.texts.get(name) != now.texts.get(name)
    ]
    other = sorted(was.signals.keys() ^ now.signals.keys())
    names += [f"{name}: {'gone' if name in was.signals else 'new'}" for name in other]
    shared = [name for name in was.signals if name in now.signals]
    found = [
        _by_how_much(name, was.signals[name], now.signals[name], tolerance) for name in shared
    ]
    late = sorted((each for each in found if each), key=lambda each: each[0])
    return [words for _, words in late] + names


def main() -> None:
    """Record sessions anew, and print what changed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="+", choices=MAPPINGS)
    for name in parser.parse_args().names:
        file, now = FOLDER / f"{name}.npz", recorded(name)
        found = differences(load(file), now, tolerance_of(name)) if file.exists() else ["new"]
        print(f"{name}: {len(found)} differ", *found[:5], sep="\n    ")
        if found:
            save(now, file)


if __name__ == "__main__":
    main()
