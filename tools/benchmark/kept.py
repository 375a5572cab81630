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


class Kept:
    """Finished items of a folder, made if missing; None: nothing is kept.

    Parameters
    ----------
    folder
        Where they are.
    workers, dask
        As for :func:`pmwvc_analysis.maps.workers.finished`.
    done
        Called after every item.
    """

    def __init__(
        self,
        folder: Path | None = None,
        *,
        workers: int | None = None,
        dask: str | None = None,
        done: Callable[[], None] = lambda: None,
    ) -> None:
        self._path = folder / FILE if folder else None
        self._workers, self._dask, self._done = workers, dask, done
        self._known: dict[str, Mapping[str, Any]] = {}
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._known = dict(_lines(self._path)) if self._path.exists() else {}

    def results(self, work: Callable[[T], R], items: Sequence[T], kind: type[R]) -> dict[T, R]:
        """Return the result of every item, in their order: those known, and the others computed.

        Parameters
        ----------
        work, items
            What is done with each; items are frozen dataclasses.
        kind
            The dataclass of a result.
        """
        known = self.finished(items, kind)
        for _ in known:
            self._done()
        missing = [item for item in items if item not in known]
        for item, result in finished(work, missing, workers=self._workers, dask=self._dask):
            self._keep(_name(item), dataclasses.asdict(result))  # type: ignore[call-overload]
            self._done()
        return self.finished(items, kind)

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
    """Return what names the sources of core, analysis and benchmark."""
    folders = [Path(str(module.__file__)).parent for module in (pmwvc_core, pmwvc_analysis)]
    digest = hashlib.sha256()
    for folder in (*folders, Path(__file__).parent):
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()
