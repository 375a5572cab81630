# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compute all figures and write them: ``python -m reproduction [NAME...]``."""

import argparse
from pathlib import Path

from rich.progress import Progress

from reproduction.pages import write_pages
from reproduction.production import produce_all
from reproduction.registry import FIGURES


def main() -> None:
    """Compute, write, show how far it is."""
    parser = argparse.ArgumentParser(prog="make figures")
    parser.add_argument("names", nargs="*", metavar="NAME", help="figures, such as B2; all")
    parser.add_argument("--folder", type=Path, default=Path("docs/reproduction"))
    options = parser.parse_args()
    if unknown := set(options.names) - set(FIGURES):
        parser.error(f"no such figure: {', '.join(sorted(unknown))}; known: {', '.join(FIGURES)}")
    names = options.names or list(FIGURES)
    with Progress() as progress:
        bar = progress.add_task("figures", total=len(names))
        for name in produce_all(names, options.folder):
            progress.console.print(f"{name}  {FIGURES[name].title}")
            progress.advance(bar)
    write_pages(options.folder)


if __name__ == "__main__":
    main()
