# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Options that several commands take, each said once."""

import argparse


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add the scenario and its number of users."""
    parser.add_argument("scenario", metavar="SCENARIO", help="name, or a YAML file")
    parser.add_argument("--users", type=int, metavar="N", help="number of users, 1 to 8")


def add_settings(parser: argparse.ArgumentParser, *, what: str = "a parameter") -> None:
    """Add ``--set``."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help=f"change {what}; may be repeated",
    )


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add what every question about the model of a scenario takes."""
    add_scenario(parser)
    add_settings(parser)
    parser.add_argument(
        "--live", action="store_true", help="use the loop phases of a live session"
    )


def add_json(
    parser: argparse.ArgumentParser, text: str = "print JSON on stdout and nothing else"
) -> None:
    """Add ``--json`` with what it prints."""
    parser.add_argument("--json", action="store_true", help=text)


def add_check(parser: argparse.ArgumentParser) -> None:
    """Add ``--check``, which makes the verdict the exit code."""
    parser.add_argument(
        "--check",
        action="store_true",
        help="exit with 1 unless the session was stable, passive, complete and recorded whole",
    )
