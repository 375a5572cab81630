# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two pages beside the figures, written from the committed results."""

from pathlib import Path

from pmwvc_analysis.reproduction.claim import Numbers, row
from pmwvc_analysis.reproduction.claims import CLAIMS
from pmwvc_analysis.reproduction.files import read
from pmwvc_analysis.reproduction.registry import FIGURES, WITH_THEIR_CONTROLLER

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
            f"## App. {name[0]}, Fig. {name[1:]}: {figure.title}",
            "",
            figure.remark + f" [Data]({name}.json).",
            "",
            f"![{figure.title}]({name}.png)",
            "",
        ]
    lines += ["## Figures that come with their controller", ""]
    lines += [f"- {name}: {what}" for name, what in WITH_THEIR_CONTROLLER.items()]
    return "\n".join(lines) + "\n"


def write_pages(folder: Path) -> None:
    """Write both pages."""
    (folder / "claims.md").write_text(claims_page(known_numbers(folder)), encoding="utf-8")
    (folder / "README.md").write_text(index_page(), encoding="utf-8")
