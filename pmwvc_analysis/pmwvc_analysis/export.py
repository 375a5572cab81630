# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as tables, one row per tick, block, step or packet, and these as files:
CSV for spreadsheets, MAT for MATLAB and Octave, HDF5.

Columns are named as in the traces (:mod:`pmwvc_core.traces`); a vector is a matrix ``(row, dof)``.
CSV is a folder with a file per table and ``columns.csv``, which has the units. MAT holds a struct
and HDF5 a group per table.
"""

import csv
import importlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import PmwvcError, file_errors
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


class Field(NamedTuple):
    """The unit and the meaning of a column."""

    unit: str
    meaning: str


_TIME = Field("s", "time since the start of the session")
_LOOKED = Field(
    "ns", "from the deadline to the look at the packets that had come; NaN where it is not known"
)
TICKS: Mapping[str, Field] = {
    "time_s": _TIME,
    "tick": Field("", "number of the tick of the force loop"),
    "x_m": Field("m", "position of the device"),
    "xd_m": Field("m/s", "velocity of the device"),
    "f_h": Field("N", "force of the hand on the device; NaN where it is not known"),
    "f_m": Field("N", "force asked for by the controller"),
    "f_applied": Field("N", "force on the device, after the safety limits"),
    "u_m": Field("sqrt(W)", "wave out of the master before its filter"),
    "u_m_lp": Field("sqrt(W)", "wave out of the master after its filter"),
    "v_m": Field("sqrt(W)", "wave into the master after the hold"),
    "lateness_s": Field("s", "wake-up behind its deadline"),
    "compute_s": Field("s", "time the tick took"),
    "looked_ns": _LOOKED,
}
BLOCKS: Mapping[str, Field] = {
    "time_s": Field("s", "end of the block"),
    "state": Field("", "0 starting, 1 coupled, 2 damping, 3 fault"),
}
STEPS: Mapping[str, Field] = {
    "time_s": _TIME,
    "step": Field("", "number of the step of the server"),
    "periods_s": Field("s", "how long the step lasts"),
    "x_o": Field("m", "position of the object"),
    "xd_o": Field("m/s", "velocity of the object"),
    "target": Field("m", "where the task wants the object"),
    "kinetic": Field("J", "kinetic energy of the object"),
    "potential": Field("J", "energy stored in the springs of the contacts"),
    "dissipated": Field("J", "heat of object and contacts so far"),
    "looked_ns": _LOOKED,
}
AVATARS: Mapping[str, Field] = {
    "x_s": Field("m", "position of the avatar"),
    "xd_s": Field("m/s", "velocity of the avatar"),
    "f_s": Field("N", "contact force on the avatar"),
    "u_s": Field("sqrt(W)", "wave received by the server"),
    "v_s": Field("sqrt(W)", "wave sent by the server"),
    "contact": Field("", "1 in contact with the object"),
    "state": Field("", "0 absent, 1 joining, 2 coupled, 3 damping"),
    "energy_u_s": Field("J", "energy of the waves received so far"),
    "energy_v_s": Field("J", "energy of the waves sent so far"),
}
PACKETS: Mapping[str, Field] = {
    "time_s": Field("s", "when the packet was recorded"),
    "epoch": Field("", "which start of the sender sent it"),
    "seq": Field("", "number of the packet"),
    "sent_ns": Field("ns", "time of sending on the sender's monotonic clock"),
    "wave": Field("sqrt(W)", "the wave in the packet"),
    "integral": Field("sqrt(W) s", "running integral of the wave"),
    "energy": Field("J", "energy sent so far"),
    "position": Field("m", "position of the sending end; an avatar's in the frame of its device"),
}
FATES: Mapping[str, Field] = {
    "number": Field("", "number of the packet on the link"),
    "epoch": Field("", "which start of the sender sent it"),
    "seq": Field("", "number given by the sender"),
    "size_bytes": Field("bytes", "size of the packet"),
    "time_in_ns": Field("ns", "when it came in, on the emulator's monotonic clock"),
    "time_due_ns": Field("ns", "when it was due to go out"),
    "time_out_ns": Field("ns", "when it went out; 0: never"),
    "fate": Field(
        "", "0 delivered, 1 lost, 2 duplicate, 3 dropped by the rate, 4 queue full, 5 invalid"
    ),
    "cause": Field("", "0 none, else what decided the fate (PacketFate in docs/messages.md)"),
}


@dataclass(frozen=True)
class Table:
    """Columns that have the same rows, and what they mean."""

    name: str
    columns: Mapping[str, NDArray[Any]]  # (row,) or (row, dof)
    meanings: Mapping[str, Field]


def tables(traces: SessionTraces) -> list[Table]:
    """Return every signal of a session, users first; names are plain words."""
    found = [table for user in traces.users for table in _of_user(user)]
    found += _of_server(traces.server) if traces.server is not None else []
    found += [
        _table(f"packets_{packets.topic.strip('/')}", packets, PACKETS)
        for packets in traces.packets.values()
    ]
    found += [_table(f"fates_{fates.link}", fates, FATES) for fates in traces.fates.values()]
    return found


def _of_user(user: UserTraces) -> Iterator[Table]:
    yield _table(user.name, user, TICKS)
    energies = {f"energy_{name}": values for name, values in user.energy.items()}
    accounts = {f"account_{name}": values for name, values in user.accounts.items()}
    meanings = {
        **BLOCKS,
        **dict.fromkeys(energies, Field("J", "energy so far, summed by the master")),
        **dict.fromkeys(accounts, Field("J", "energy kept by the controller")),
    }
    columns = {"time_s": user.block_time_s, "state": user.state, **energies, **accounts}
    yield Table(plain(f"{user.name}_blocks"), columns, meanings)


def _of_server(server: ServerTraces) -> Iterator[Table]:
    steps = _table("server", server, STEPS)
    accounts = {f"account_{name}": values for name, values in server.accounts.items()}
    meanings = {name: Field("J", "energy kept by the server") for name in accounts}
    yield Table("server", {**steps.columns, **accounts}, {**STEPS, **meanings})
    for index, user in enumerate(server.users):
        columns = {name: np.asarray(getattr(server, name)[index]) for name in AVATARS}
        columns["contact"] = columns["contact"].astype(np.uint8)
        columns = {"time_s": server.time_s, **columns}
        yield Table(plain(f"server_{user}"), columns, {"time_s": _TIME, **AVATARS})


def _table(name: str, traces: object, columns: Mapping[str, Field]) -> Table:
    values = {column: np.asarray(getattr(traces, column)) for column in columns}
    if "looked_ns" in values and not len(values["looked_ns"]):
        values["looked_ns"] = np.full(len(values["time_s"]), np.nan)
    return Table(plain(name), values, columns)


def plain(name: str) -> str:
    """Return a name that every tool accepts: letters, digits and underscores."""
    return re.sub(r"\W", "_", name)


def by_axis(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return the axes of a column by name: ``x_m`` of one axis, else ``x_m_1``, ``x_m_2``, ..."""
    if values.ndim == 1 or values.shape[1] == 1:
        return {name: values.reshape(-1)}
    return {f"{name}_{number}": axis for number, axis in enumerate(values.T, start=1)}


About = dict[str, str | float]
Writer = Callable[[Path, Sequence[Table], About], None]


def export(
    target: str | Path, traces: SessionTraces, scenario: Scenario | None, *, kind: str
) -> None:
    """Write all signals of a session for another tool, with its parameters where they are known,
    into a folder for ``csv``, which is made, else a file. RecordingError where it cannot be
    written, PmwvcError where the kind is not known, or needs a package that is not installed.
    """
    if kind not in KINDS:
        raise PmwvcError(f"export as {kind!r}: there are {', '.join(KINDS)}")
    about: About = {"source": traces.source, "recorded_s": traces.duration_s}
    for name, value in ({"scenario": scenario.name} | scenario.flat() if scenario else {}).items():
        about[name] = value if isinstance(value, int | float) else str(value)
    path = Path(target)
    with file_errors(f"write {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        KINDS[kind](path, tables(traces), about)


def _write_csv(folder: Path, found: Sequence[Table], about: About) -> None:
    folder.mkdir(exist_ok=True)
    meanings = []
    for table in found:
        columns: dict[str, NDArray[Any]] = {}
        for name, values in table.columns.items():
            axes = by_axis(name, values)
            columns |= axes
            meanings += [(table.name, axis, *table.meanings[name]) for axis in axes]
        rows = zip(*(values.tolist() for values in columns.values()), strict=True)
        _rows(folder / f"{table.name}.csv", columns, rows)
    _rows(folder / "columns.csv", ["table", "column", "unit", "meaning"], meanings)
    _rows(folder / "parameters.csv", ["parameter", "value"], about.items())


def _rows(file: Path, head: Iterable[str], rows: Any) -> None:
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
    content["parameters"] = np.array(list(about.items()), dtype=object)  # names have dots
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
