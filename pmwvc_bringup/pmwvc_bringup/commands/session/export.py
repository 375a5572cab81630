# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc export``: the signals of a recorded session for other tools."""

import argparse
from pathlib import Path

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import FOLDER, out

EXAMPLES = """\
examples:
  pmwvc export sessions/20260101T120000Z-carry_16ms                 a folder of CSV files
  pmwvc export sessions/20260101T120000Z-carry_16ms --as mat        for MATLAB and Octave
  pmwvc export sessions/20260101T120000Z-carry_16ms --as hdf5 --out /tmp/carry.h5
"""
TARGETS = {"csv": "csv", "mat": "session.mat", "hdf5": "session.h5"}


def run(arguments: argparse.Namespace) -> Result:
    """Read the recording and write the files."""
    from pmwvc_analysis.export.files import export
    from pmwvc_analysis.recording.reader import read_scenario, read_session

    folder = Path(arguments.folder)
    target = Path(arguments.out) if arguments.out else folder / TARGETS[arguments.kind]
    export(target.expanduser(), read_session(folder), read_scenario(folder), kind=arguments.kind)
    print(target)
    return Result()


COMMAND = Command(
    name="export",
    help="write the signals of a recorded session as CSV, MAT or HDF5",
    examples=EXAMPLES,
    arguments=(
        FOLDER,
        argument(
            "--as",
            dest="kind",
            choices=tuple(TARGETS),
            default="csv",
            help="what to write (default: csv)",
        ),
        out("file, or folder of CSV files (default: in the session folder)", metavar="PATH"),
    ),
    run=run,
)
