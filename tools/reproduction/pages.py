# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages beside the figures, written from the committed results."""

import textwrap
from pathlib import Path

from reproduction.claim import Numbers, row
from reproduction.claims import CLAIMS
from reproduction.draw_position_drift import table
from reproduction.files import read
from reproduction.registry import FIGURES

GENERATED = "<!-- written by make figures -->\n"


def known_numbers(folder: Path) -> Numbers:
    """Return the numbers of every committed result."""
    return {name: read(name, folder)["numbers"] for name in FIGURES}


def claims_page(numbers: Numbers) -> str:
    """Return claims.md."""
    lines = [
        GENERATED,
        "# Claims of the dissertation",
        "",
        "Our values come from the results beside the [figures](README.md); nothing is fitted.",
        "A number counts as reproduced within 5 % (15 % where the claim is that something hardly",
        "matters, 0.1 % for the optimised α). *At least* and *at most* are how we read a claim in",
        "words, such as *stiffer* or *much smaller*. Experiments were made on real devices.",
        "*The number agrees* stands where it does and the claim is still not supported, with the",
        "reason: a condition, a coincidence, the window of a plot, a part that is not passive, or",
        "a triviality.",
        "",
        "| where | claim | printed | ours | what decides | verdict |",
        "|---|---|---|---|---|---|",
    ]
    for claim in CLAIMS:
        printed, ours, verdict = row(claim, numbers)
        says, choice = (text.replace("|", "\\|") for text in (claim.says, claim.choice))
        lines.append(f"| {claim.where} | {says} | {printed} | {ours} | {choice} | {verdict} |")
    return "\n".join(lines) + "\n"


def index_page() -> str:
    """Return README.md of the folder."""
    lines = [
        GENERATED,
        "# The dissertation's figures, computed again",
        "",
        "Written by `make figures`. Beside every picture stands a JSON file with its data, its",
        "numbers and the parameters it was made with.",
        "[claims.md](claims.md): what is claimed, and what we find.",
        "",
    ]
    for name, figure in FIGURES.items():
        lines += [
            f"## {_place(name)}: {figure.title}",
            "",
            figure.remark + f" [Data]({name}.json).",
            "",
            f"![{figure.title}]({name}.svg)",
            "",
        ]
    return "\n".join(lines[:-1]) + "\n"


def _place(name: str) -> str:
    """Return where the dissertation has a figure."""
    known = name[1:].isdigit()
    return f"App. {name[0]}, Fig. {name[1:]}" if known else "Beside the dissertation"


def drift_page(folder: Path) -> str:
    """Return position_drift.md."""
    result = read("position_drift", folder)
    lines = [
        GENERATED,
        f"# {result['title']}",
        "",
        f"K_p = {result['parameters']['gain']:g} sqrt(W)/m, two users; both devices together: how",
        "much closer than their avatars they are (RMS over the session, mean of the last 0.5 s),",
        "the force of each, what the feedback gave out, and the least balance of a user's ports.",
        *textwrap.wrap(result["remark"], 95),
        "",
        *table(result),
        "",
        f"![{result['title']}](position_drift.svg)",
    ]
    return "\n".join(lines) + "\n"


def write_pages(folder: Path) -> None:
    """Write the pages."""
    (folder / "position_drift.md").write_text(drift_page(folder), encoding="utf-8")
    (folder / "claims.md").write_text(claims_page(known_numbers(folder)), encoding="utf-8")
    (folder / "README.md").write_text(index_page(), encoding="utf-8")
