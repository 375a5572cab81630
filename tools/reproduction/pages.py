# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages beside the figures, written from the committed results."""

import re
import textwrap
from collections import Counter
from itertools import groupby
from pathlib import Path

from reproduction.claim import Claim, Numbers, row
from reproduction.claims import CLAIMS
from reproduction.draw_position_drift import table
from reproduction.files import read
from reproduction.registry import FIGURES

GENERATED = "<!-- written by make figures -->\n"
CASE = re.compile(r"(.*?)(?:,? (\(.*|T_d = .*))?$")  # of a claim: its words, and the case
SHORT = 24  # characters: no note is worth while
SENTENCE = re.compile(r"(?<!App\.)(?<!Fig\.)(?<!Eq\.)(?<=\.)\s+")


def known_numbers(folder: Path) -> Numbers:
    """Return the numbers of every committed result."""
    return {name: read(name, folder)["numbers"] for name in FIGURES}


def claims_page(numbers: Numbers) -> str:
    """Return claims.md."""
    lines = [
        GENERATED,
        "# Claims of the dissertation",
        "",
        "What the dissertation claims, and what the results beside the [figures](README.md) show.",
        "Nothing is fitted. The claimed experiments used real devices. A number is reproduced if",
        "it is within 5 % (15 % for claims that something hardly matters, 0.1 % for the optimised",
        "α). Bounds are our reading of words such as *stiffer*. *The number agrees* means that it",
        "supports the claim only with the stated reservation. A row without a place continues the",
        "claim above it.",
    ]
    for appendix, claims in groupby(CLAIMS, key=lambda claim: claim.where[0]):
        lines += ["", f"## App. {appendix}", "", *_claims_table(list(claims), numbers)]
    return "\n".join(lines) + "\n"


def _claims_table(claims: list[Claim], numbers: Numbers) -> list[str]:
    """Return the notes that several claims share, and a row for each claim."""
    texts = [text for claim in claims for text in (*claim.choice.split("; "), claim.only)]
    uses = Counter(text for text in texts if text)
    marks = {text: f"({index})" for index, text in enumerate(_shared(uses), start=1)}
    lines = [f"- {mark} {text}" for text, mark in marks.items()]
    lines += [""] if lines else []
    lines += [
        "| where | claim | printed | ours | deciding assumption | verdict |",
        "|---|---|---|---|---|---|",
    ]
    before = ("", "")
    for claim in claims:
        printed, ours, verdict = row(claim, numbers)
        stem, rest = CASE.match(claim.says).groups()  # type: ignore[union-attr]
        again = (claim.where, stem) == before
        where, says = ("", rest) if again else (claim.where[2:], claim.says)
        before = claim.where, stem
        choice = "; ".join(marks.get(text, text) for text in claim.choice.split("; "))
        if claim.only:
            verdict = verdict.replace(claim.only, marks.get(claim.only, claim.only))
        cells = (where, says, printed, ours, choice, verdict)
        lines.append("| " + " | ".join(text.replace("|", "\\|") for text in cells) + " |")
    return lines


def _shared(uses: Counter[str]) -> list[str]:
    """Return the longer texts that are used more than once, in their order."""
    return [text for text, count in uses.items() if count > 1 and len(text) > SHORT]


def index_page() -> str:
    """Return README.md of the folder."""
    lines = [
        GENERATED,
        "# The dissertation's figures, recomputed",
        "",
        "`make figures` writes the figures, and this page. Each figure has a JSON file with its",
        "data, numbers and parameters. The dissertation's claims against our results:",
        "[claims](claims.md).",
    ]
    for appendix, names in groupby(FIGURES, key=_appendix):
        lines += ["", f"## {appendix}", "", *_figures(list(names))]
    return "\n".join(lines) + "\n"


def _figures(names: list[str]) -> list[str]:
    """Return what several figures of an appendix have in common, and each figure."""
    sentences = {name: SENTENCE.split(FIGURES[name].remark.strip()) for name in names}
    uses = Counter(each for remark in sentences.values() for each in remark)
    lines = []
    for common in _shared(uses):
        figures = ", ".join(_figure(name) for name in names if common in sentences[name])
        lines.append(f"- Fig. {figures}: {common}")
    for name in names:
        own = [each for each in sentences[name] if each not in _shared(uses)]
        number = f"Fig. {_figure(name)}: " if _figure(name) else ""
        lines += [
            "",
            f"### {number}{FIGURES[name].title}",
            "",
            " ".join((*own, f"[Data]({name}.json)")),
            "",
            f"![{number[:-2] or name}]({name}.svg)",
        ]
    return lines if lines[0] else lines[1:]


def _appendix(name: str) -> str:
    """Return the appendix of the dissertation that a figure belongs to."""
    return f"App. {name[0]}" if _figure(name) else "Beside the dissertation"


def _figure(name: str) -> str:
    """Return the number that a figure has there; empty: it has none."""
    return name[1:] if name[1:].isdigit() else ""


def drift_page(folder: Path) -> str:
    """Return position_drift.md."""
    result = read("position_drift", folder)
    lines = [
        GENERATED,
        f"# {result['title']}",
        "",
        f"K_p = {result['parameters']['gain']:g} sqrt(W)/m, two users. Both devices together: how",
        "much closer they are than their avatars (RMS, mean of the last 0.5 s), force of each,",
        "the energy spent by the feedback, and the minimum energy balance of a user's ports.",
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
