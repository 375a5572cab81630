# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages beside the figures, written from the committed results."""

import re
import textwrap
from collections import Counter
from itertools import groupby
from pathlib import Path

from reproduction.claim import REPRODUCED, Claim, Numbers, row
from reproduction.claims import CLAIMS
from reproduction.draw_position_drift import table
from reproduction.files import read
from reproduction.registry import FIGURES

GENERATED = "<!-- written by make figures -->\n"
CASE = re.compile(r",? (\(.*|T_d = .*)$")  # of a claim
AMOUNT = re.compile(r"(?<=differs) by .*$|(?<=reproduced) \(.*\)$")  # the columns before show it
SHORT = 16  # characters: no note is worth while


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
        "Nothing is fitted; the claimed experiments used real devices. A number is reproduced if",
        "it is within 5 % (15 % for claims that something hardly matters, 0.1 % for the optimised",
        "α). Bounds are our reading of words such as *stiffer*. *The number agrees*, but with the",
        "reservation stated. Bounds and choices of all claims: `tools/reproduction/claims*.py`.",
    ]
    for appendix, claims in groupby(CLAIMS, key=lambda claim: claim.where[0]):
        lines += ["", f"## App. {appendix}", "", *_claims_table(list(claims), numbers)]
    return "\n".join(lines) + "\n"


def _claims_table(claims: list[Claim], numbers: Numbers) -> list[str]:
    """Return the claims that are reproduced, the notes that the others share, and their rows."""
    cases = [list(c) for _, c in groupby(claims, key=lambda c: (c.where, _stem(c), c.choice))]
    reproduced = [each for each in cases if _reproduced(each, numbers)]
    others = [each for each in cases if each not in reproduced]
    claims = [claim for each in others for claim in each]
    texts = [text for claim in claims for text in (*claim.choice.split("; "), claim.only)]
    uses = Counter(text for text in texts if text)
    marks = {text: f"({index})" for index, text in enumerate(_shared(uses), start=1)}
    rows = [_claims_row(each, {}, numbers) for each in reproduced]
    lines = [
        "Reproduced:",
        "",
        *(f"- {where}: {says}: {ours}" for where, says, _, ours, *_ in rows),
    ]
    lines += ["", "The others:", "", *(f"- {mark} {text}" for text, mark in marks.items()), ""]
    lines += [
        "| where | claim | printed | ours | deciding assumption | verdict |",
        "|---|---|---|---|---|---|",
    ]
    for each in others:
        cells = (text.replace("|", "\\|") for text in _claims_row(each, marks, numbers))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def _reproduced(cases: list[Claim], numbers: Numbers) -> bool:
    return all(row(case, numbers)[2].startswith(REPRODUCED) for case in cases)


def _claims_row(cases: list[Claim], marks: dict[str, str], numbers: Numbers) -> tuple[str, ...]:
    """Return the cells of a claim, its cases one after another in every cell."""
    first = cases[0]
    found = []
    for case in cases:
        printed, ours, verdict = row(case, numbers)
        if case.only:
            verdict = verdict.replace(case.only, marks.get(case.only, case.only))
        found.append((printed, ours, AMOUNT.sub("", verdict)))
    stem, says = _stem(first), first.says
    if len(cases) > 1:
        says = f"{stem} ({'; '.join(case.says[len(stem) :].strip(' ,()') for case in cases)})"
    choice = "; ".join(marks.get(text, text) for text in first.choice.split("; "))
    printed, ours, verdict = (
        texts[0] if len(set(texts)) == 1 else "; ".join(texts)
        for texts in zip(*found, strict=True)
    )
    return first.where[2:], says, printed, ours, choice, verdict


def _stem(claim: Claim) -> str:
    """Return the words of a claim without its case."""
    return CASE.sub("", claim.says)


def _shared(uses: Counter[str]) -> list[str]:
    """Return the longer texts that are used more than once, in their order."""
    return [text for text, count in uses.items() if count > 1 and len(text) > SHORT]


def index_page() -> str:
    """Return README.md of the folder."""
    lines = [
        GENERATED,
        "# The dissertation's figures, recomputed",
        "",
        "`make figures` writes the figures, and this page. Below each figure stand the choices",
        "that it depends on; data, numbers and parameters of `A3.svg` are in `A3.json`. The",
        "dissertation's claims against our results: [claims](claims.md).",
    ]
    for appendix, names in groupby(FIGURES, key=_appendix):
        lines += ["", f"## {appendix}"]
        for name in names:
            number = f"Fig. {_figure(name)}" if _figure(name) else ""
            title = ": ".join(filter(None, (number, FIGURES[name].title)))
            lines += ["", f"### {title}", "", f"![{name}]({name}.svg)"]
    return "\n".join(lines) + "\n"


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
