# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Make the figures of docs/paper.md, and the tables in it: ``python -m paper [NAME...]``."""

import argparse
import sys
import time

from paper import adversarial, bound, losses, stiffness, summary
from paper.numbers import PAGE, inserted, read, write

FIGURES = {each.NAME: each for each in (bound, losses, stiffness, adversarial, summary)}


def main() -> int:
    """Make the figures named, or all; the tables of others stay as they are."""
    parser = argparse.ArgumentParser(prog="make paper")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(FIGURES)}; all")
    names = parser.parse_args().names or list(FIGURES)
    if unknown := set(names) - set(FIGURES):
        parser.error(f"no such figure: {', '.join(sorted(unknown))}; known: {', '.join(FIGURES)}")
    tables = read()
    for name in names:
        began = time.monotonic()
        tables[name] = FIGURES[name].make()
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
        for row in tables[name]:
            print(f"  {' | '.join(row)}")
    write({name: tables[name] for name in FIGURES if name in tables})
    PAGE.write_text(inserted(PAGE.read_text("utf-8"), tables), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
