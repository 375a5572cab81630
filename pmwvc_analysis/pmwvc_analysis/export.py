# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as tables, one row per tick, block, step or packet, and these as files:
CSV for spreadsheets, MAT for MATLAB and Octave.

Columns are named as in the traces (:mod:`pmwvc_core.traces`); a vector is a matrix ``(row, dof)``.
CSV is a folder with a file per table and ``columns.csv``, which has the units. MAT holds a struct
per table.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.arrays import write_table
from pmwvc_core.errors import PmwvcError, file_errors
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import OF_USERS, ServerTraces, SessionTraces, UserTraces


class Field(NamedTuple):
    """The unit and the meaning of a column."""

    unit: str
    meaning: str


def declared(kind: type) -> dict[str, Field]:
    """Return the columns that traces of a kind declare."""
    hints = get_type_hints(kind, include_extras=True).items()
    found = ((name, getattr(hint, "__metadata__", ())) for name, hint in hints)
    return {name: Field(*texts) for name, texts in found if texts}


OF_CONTACT = {
    "time_s": Field("s", "time since the start of the session"),
    **dict.fromkeys(("body", "other"), Field("", "two bodies of a scene that touch")),
    "x": Field("m", "where, in the scene's frame"), "f": Field("N", "force on the other"),
}  # fmt: skip


class Table(NamedTuple):
    """Columns that have the same rows, and what they mean."""

    name: str
    columns: Mapping[str, NDArray[Any]]  # (row,) or (row, dof)
    meanings: Mapping[str, Field]


def tables(traces: SessionTraces) -> list[Table]:
    """Return every signal of a session, users first; names are plain words."""
    found = [table for user in traces.users for table in _of_user(user)]
    found += _of_server(traces.server) if traces.server is not None else []
    found += [
        _table(f"packets_{packets.topic.strip('/')}", packets)
        for packets in traces.packets.values()
    ]
    found += [_table(f"fates_{fates.link}", fates) for fates in traces.fates.values()]
    return found


def _of_user(user: UserTraces) -> Iterator[Table]:
    yield _table(user.name, user)
    columns = {"time_s": user.block_time_s, "state": user.state}
    meanings = {
        "time_s": Field("s", "end of the block"),
        "state": Field("", "0 starting, 1 coupled, 2 damping, 3 fault"),
    }
    for kind, sums, meaning in (
        ("energy", user.energy, "energy so far, summed by the master"),
        ("account", user.accounts, "energy kept by the controller"),
    ):
        columns |= {f"{kind}_{name}": values for name, values in sums.items()}
        meanings |= {f"{kind}_{name}": Field("J", meaning) for name in sums}
    if user.orientation.size:
        columns["orientation"] = user.orientation
        meanings["orientation"] = Field("", "of the device, unit quaternion x y z w")
    yield Table(plain(f"{user.name}_blocks"), columns, meanings)


def _of_server(server: ServerTraces) -> Iterator[Table]:
    _, columns, meanings = _table("server", server)
    accounts = {f"account_{name}": values for name, values in server.accounts.items()}
    kept = dict.fromkeys(accounts, Field("J", "energy kept by the server"))
    whole = {name: each for name, each in columns.items() if name not in OF_USERS}
    poses = {f"pose_{name}": rows for name, rows in server.poses.items()}
    of_poses = dict.fromkeys(poses, Field("m, -", "x y z, quaternion w x y z of a body"))
    yield Table("server", {**whole, **accounts, **poses}, {**meanings, **kept, **of_poses})
    if len(server.contacts):
        rows, first, second, *vectors = server.contacts.T
        names = np.array([*server.poses, "fixed"])
        touching = {"time_s": server.time_s[rows.astype(int)]}
        touching |= {"body": names[first.astype(int)], "other": names[second.astype(int)]}
        touching |= {"x": np.stack(vectors[:3], 1), "f": np.stack(vectors[3:], 1)}
        yield Table("contacts", touching, OF_CONTACT)
    for index, user in enumerate(server.users):
        own = {name: np.asarray(getattr(server, name)[index]) for name in OF_USERS}
        own["contact"] = own["contact"].astype(np.uint8)
        yield Table(plain(f"server_{user}"), {"time_s": server.time_s, **own}, meanings)


def _table(name: str, traces: object) -> Table:
    meanings = declared(type(traces))
    values = {column: np.asarray(getattr(traces, column)) for column in meanings}
    there = {column: each for column, each in values.items() if each.shape[1:] != (0,)}
    return Table(plain(name), there, meanings)


def plain(name: str) -> str:
    """Return a name that every tool accepts: letters, digits and underscores."""
    return re.sub(r"\W", "_", name)


About = dict[str, str | float]
Writer = Callable[[Path, Sequence[Table], About], None]


def export(
    target: str | Path, traces: SessionTraces, scenario: Scenario | None, *, kind: str
) -> None:
    """Write all signals of a session for another tool, with its parameters where they are known,
    into a folder for ``csv``, which is made, else a file. RecordingError where it cannot be
    written, PmwvcError where the kind is not known.
    """
    if kind not in KINDS:
        raise PmwvcError(f"export as {kind!r}: there are {', '.join(KINDS)}")
    about: About = {"source": traces.source, "recorded_s": traces.duration_s}
    for name, value in ({"scenario": scenario.name} | scenario.flat() if scenario else {}).items():
        about[name] = value if isinstance(value, int | float) else str(value)
    if traces.server is not None and (scene := traces.server.scene):
        about["scene"] = json.dumps({**scene, "files": [*scene.get("files", ())]})
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
            named = enumerate(values.T, start=1) if values.ndim > 1 else ()
            axes = {f"{name}_{number}": axis for number, axis in named}
            if len(axes) == 1 or values.ndim == 1:
                axes = {name: values.reshape(-1)}
            columns |= axes
            meanings += [(table.name, axis, *table.meanings[name]) for axis in axes]
        write_table(folder / f"{table.name}.csv", columns)
    heads = ("table", "column", "unit", "meaning")
    write_table(folder / "columns.csv", dict(zip(heads, zip(*meanings, strict=True), strict=True)))
    parameters: dict[str, Sequence[Any]] = {"parameter": [*about], "value": [*about.values()]}
    write_table(folder / "parameters.csv", parameters)


def _write_mat(file: Path, found: Sequence[Table], about: About) -> None:
    from scipy.io import savemat

    content: dict[str, Any] = {table.name: dict(table.columns) for table in found}
    content["units"] = {
        table.name: {name: table.meanings[name].unit for name in table.columns} for table in found
    }
    content["parameters"] = np.array(list(about.items()), dtype=object)  # names have dots
    savemat(file, content, do_compression=True, long_field_names=True)


KINDS: dict[str, Writer] = {"csv": _write_csv, "mat": _write_mat}
