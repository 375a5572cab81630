# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a study on disk: a line for each finished item, so that a study that was
interrupted goes on.

A line is named by the item and by the sources of the program: other code or other settings never
meet old results.
"""

import dataclasses
import functools
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import pmwvc_analysis
import pmwvc_core
from pmwvc_analysis.maps.workers import finished

FILE = "finished.jsonl"
T = TypeVar("T")
R = TypeVar("R")


def alone(item: object) -> object:
    """Say that no items are worked on together."""
    return item


class Kept:
    """Finished items of a folder, made if missing; None: nothing is kept.

    Parameters
    ----------
    folder
        Where they are.
    workers, dask
        As for :func:`pmwvc_analysis.maps.workers.finished`.
    done
        Called with the number of items that are finished.
    """

    def __init__(
        self,
        folder: Path | None = None,
        *,
        workers: int | None = None,
        dask: str | None = None,
        done: Callable[[int], None] = lambda number: None,
    ) -> None:
        self._path = folder / FILE if folder else None
        self._workers, self._dask, self._done = workers, dask, done
        self._known: dict[str, Mapping[str, Any]] = {}
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._known = dict(_lines(self._path)) if self._path.exists() else {}

    def results(
        self,
        work: Callable[[tuple[T, ...]], list[R]],
        items: Sequence[T],
        kind: type[R],
        together: Callable[[T], object] = alone,
    ) -> dict[T, R]:
        """Return the result of every item, in their order: those known, and the others computed.

        Parameters
        ----------
        work, items
            What is done with some of them; items are frozen dataclasses.
        kind
            The dataclass of a result.
        together
            Items for which this is the same are worked on together.
        """
        known = self.finished(items, kind)
        self._done(len(known))
        missing: dict[object, list[T]] = {}
        for item in dict.fromkeys(items):
            if item not in known:
                missing.setdefault(together(item), []).append(item)
        parts = [tuple(part) for part in missing.values()]
        for part, results in finished(work, parts, workers=self._workers, dask=self._dask):
            for item, result in zip(part, results, strict=True):
                self._keep(_name(item), dataclasses.asdict(result))  # type: ignore[call-overload]
            self._done(len(part))
        return self.finished(items, kind)

    def prepare(self, work: Callable[[tuple[T, ...]], object], items: Sequence[T]) -> None:
        """Do some work of which nothing is kept, each item by itself."""
        parts = [(item,) for item in items]
        for _ in finished(work, parts, workers=self._workers, dask=self._dask):
            pass

    def finished(self, items: Sequence[T], kind: type[R]) -> dict[T, R]:
        """Return the results that are known, in the order of the items."""
        names = {item: _name(item) for item in items}
        return {item: kind(**self._known[n]) for item, n in names.items() if n in self._known}

    def _keep(self, name: str, result: Mapping[str, Any]) -> None:
        self._known[name] = result
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps([name, result]) + "\n")


def _lines(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield what a file holds; a line that was cut off is left out."""
    for line in path.read_text("utf-8").splitlines():
        try:
            name, result = json.loads(line)
        except ValueError:
            continue
        yield name, result


def _name(item: object) -> str:
    return hashlib.sha256(f"{_sources()} {item!r}".encode()).hexdigest()


@functools.cache
def _sources() -> str:
    """Return what names the sources of core and analysis, and what the benchmark measures with."""
    folders = [Path(str(module.__file__)).parent for module in (pmwvc_core, pmwvc_analysis)]
    files = [file for folder in folders for file in folder.rglob("*.py")]
    here = Path(__file__).parent
    files += [file for file in here.rglob("*.py") if file.name not in SHOWING]
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.read_bytes())
    return digest.hexdigest()


# What only shows results: a change of it lets them stand.
SHOWING = ("better.py", "columns.py", "drawn.py", "estimate.py", "reasons.py", "swept.py",
           "written.py", "__main__.py")  # fmt: skip
