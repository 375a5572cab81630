# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables of a session as files: CSV for spreadsheets, MAT for MATLAB and Octave, HDF5.

CSV is a folder with a file per table and ``columns.csv``, which has the units. MAT holds a struct
and HDF5 a group per table; vectors are matrices ``(row, dof)`` there.
"""

import csv
import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.export.tables import Table, by_axis, tables
from pmwvc_core.errors import PmwvcError, file_errors
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

About = dict[str, str | float]
Writer = Callable[[Path, Sequence[Table], About], None]


def export(
    target: str | Path, traces: SessionTraces, scenario: Scenario | None, *, kind: str
) -> None:
    """Write all signals of a session for another tool, with its parameters where they are known.

    The target is a folder for ``csv``, which is made, else a file.

    Raises
    ------
    PmwvcError
        If the kind is not known, or needs a package that is not installed.
    RecordingError
        If the target cannot be written.
    """
    if kind not in KINDS:
        raise PmwvcError(f"export as {kind!r}: there are {', '.join(KINDS)}")
    about: About = {"source": traces.source, "recorded_s": traces.duration_s}
    if scenario is not None:
        about["scenario"] = scenario.name
        about |= {
            name: value if isinstance(value, int | float) else str(value)
            for name, value in scenario.flat().items()
        }
    path = Path(target)
    with file_errors(f"write {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        KINDS[kind](path, tables(traces), about)


def _write_csv(folder: Path, found: Sequence[Table], about: About) -> None:
    folder.mkdir(exist_ok=True)
    for table in found:
        columns = [
            axis for name, values in table.columns.items() for axis in by_axis(name, values)
        ]
        rows = zip(*(values.tolist() for _, values in columns), strict=True)
        _rows(folder / f"{table.name}.csv", [name for name, _ in columns], rows)
    meanings = [
        (table.name, axis, *table.meanings[name])
        for table in found
        for name, values in table.columns.items()
        for axis, _ in by_axis(name, values)
    ]
    _rows(folder / "columns.csv", ["table", "column", "unit", "meaning"], meanings)
    _rows(folder / "parameters.csv", ["parameter", "value"], about.items())


def _rows(file: Path, head: Sequence[str], rows: Any) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(head)
        table.writerows(rows)


def _write_mat(file: Path, found: Sequence[Table], about: About) -> None:
    from scipy.io import savemat

    content: dict[str, Any] = {table.name: dict(table.columns) for table in found}
    content["units"] = {
        table.name: {name: table.meanings[name].unit for name in table.columns} for table in found
    }
    content["parameters"] = np.array(
        [[name, value] for name, value in about.items()], dtype=object
    )  # a cell array: names have dots
    savemat(file, content, do_compression=True, long_field_names=True)


def _write_hdf5(file: Path, found: Sequence[Table], about: About) -> None:
    try:
        h5py: Any = importlib.import_module("h5py")
    except ImportError:
        raise PmwvcError(
            "HDF5 needs the package h5py: pip install 'pmwvc[hdf5]'; or export as csv or mat"
        ) from None
    with h5py.File(file, "w") as stream:
        stream.attrs.update(about)
        for table in found:
            group = stream.create_group(table.name)
            for name, values in table.columns.items():
                data = group.create_dataset(name, data=values)
                data.attrs["unit"] = table.meanings[name].unit
                data.attrs["meaning"] = table.meanings[name].meaning


KINDS: dict[str, Writer] = {"csv": _write_csv, "mat": _write_mat, "hdf5": _write_hdf5}
