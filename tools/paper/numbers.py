# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of the paper: kept in docs/paper_numbers.csv, and put into docs/paper.md between
``<!-- numbers: NAME -->`` and ``<!-- end -->``.
"""

import csv
import io
import re

from paper.drawing import ROOT, Rows

PAGE, NUMBERS = ROOT / "docs" / "paper.md", ROOT / "docs" / "paper_numbers.csv"
BLOCK = re.compile(r"(<!-- numbers: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def read() -> dict[str, Rows]:
    """Return the tables by figure; none where the file is not there."""
    tables: dict[str, Rows] = {}
    if NUMBERS.exists():
        for name, *cells in csv.reader(NUMBERS.read_text("utf-8").splitlines()):
            tables.setdefault(name, []).append(cells)
    return tables


def write(tables: dict[str, Rows]) -> None:
    """Write the tables."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerows([name, *row] for name, rows in tables.items() for row in rows)
    NUMBERS.write_text(stream.getvalue(), "utf-8")


def inserted(page: str, tables: dict[str, Rows]) -> str:
    """Return a page with its tables."""

    def block(found: re.Match[str]) -> str:
        begin, name, end = found.groups()
        return f"{begin}\n{table(tables.get(name, []))}\n{end}"

    return BLOCK.sub(block, page)


def table(rows: Rows) -> str:
    """Return a table."""
    if not rows:
        return "(not measured yet)\n"
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "".join(f"| {' | '.join(row)} |\n" for row in lines)
