# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Values inside a MATLAB 5 file, by a path such as ``scope.signals[1].values[:,0]``."""

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_core.errors import RecordingError
from pmwvc_core.numeric import Array

_PART = re.compile(r"\.?(?P<field>[A-Za-z_]\w*)|\[(?P<index>[^\]]*)\]")


class MatlabFile:
    """Variables of a MATLAB 5 file by path."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def data(self, names: Sequence[str], time_column: str) -> Array:
        """Return the columns of all the paths, side by side."""
        if not names:
            raise RecordingError(
                f"{self.file}: operator.columns is empty; name a variable, with fields and "
                "indices as in scope.signals[1].values[:,0]; there are "
                f"{', '.join(self._variables())}"
            )
        parts = [self.column(name) for name in names]
        if len({len(part) for part in parts}) > 1:
            lengths = ", ".join(
                f"{name}: {len(part)}" for name, part in zip(names, parts, strict=True)
            )
            raise RecordingError(f"{self.file}: columns of different length ({lengths})")
        return np.hstack(parts)

    def column(self, name: str) -> Array:
        """Return what a path leads to as ``(rows, columns)``."""
        value = self._follow(name)
        try:
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError) as error:
            raise RecordingError(f"{self.file}: {name} is {_inside(value)}") from error
        if array.ndim not in (1, 2):
            raise RecordingError(
                f"{self.file}: {name} has {array.ndim} dimensions; index it down to one or two, "
                "as in values[:,0]"
            )
        return array.reshape(len(array), -1)

    def _follow(self, name: str) -> Any:
        parts = list(_PART.finditer(name))
        if not parts or "".join(part.group() for part in parts) != name or not parts[0]["field"]:
            raise RecordingError(
                f"{self.file}: cannot read {name!r}; write it as in scope.signals[1].values[:,0]"
            )
        value = self._variable(parts[0]["field"])
        for part in parts[1:]:
            try:
                field, index = part["field"], part["index"]
                value = getattr(value, field) if field else np.atleast_1d(value)[_index(index)]
            except (AttributeError, IndexError, ValueError) as error:
                done = name[: part.start()]
                raise RecordingError(
                    f"{self.file}: {done} has no {part.group().lstrip('.')}; it is "
                    f"{_inside(value)}"
                ) from error
        return value

    def _variable(self, name: str) -> Any:
        found = _load(self.file, [name])
        if name not in found:
            raise RecordingError(
                f"{self.file}: no variable {name!r}; there are {', '.join(self._variables())}"
            )
        return found[name]

    def _variables(self) -> list[str]:
        return sorted(name for name in _load(self.file, None) if not name.startswith("__"))


def _load(file: Path, names: Sequence[str] | None) -> dict[str, Any]:
    """Read variables of a MAT file (all, or those named)."""
    from scipy import io  # takes long to import, and only this needs it

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # variables without a name, which are not needed
            found: dict[str, Any] = io.loadmat(
                file, squeeze_me=True, struct_as_record=False, variable_names=names
            )
    except NotImplementedError as error:
        raise RecordingError(
            f"{file}: MATLAB 7.3 (HDF5) is not read; save it with the option -v7"
        ) from error
    except Exception as error:  # scipy raises nearly anything on a broken file
        raise RecordingError(f"{file}: not a MATLAB 5 file ({error})") from error
    return found


def _index(text: str) -> tuple[int | slice, ...]:
    """Return an index such as ``1`` or ``:,0``."""
    return tuple(slice(None) if part.strip() == ":" else int(part) for part in text.split(","))


def _inside(value: Any) -> str:
    """Say what a value is, so that the next step of a path can be written."""
    fields = getattr(value, "_fieldnames", None)
    if fields is not None:
        return f"a struct with {', '.join(fields)}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return f"a {type(value).__name__}"
