# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The answer of a transparency analysis: as plain numbers, in sentences, as files of arrays."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.arrays import write_table
from pmwvc_analysis.transparency.transparency import Transparency
from pmwvc_core.numeric import Array

NAME = "transparency"
CURVES = ("frequency_hz", "admittance", "ideal_admittance")
RENDERED = (  # what is known of it is told
    ("stiffness {:.4g} N/m", ("k_felt",)),
    ("damping {:.4g} N s/m", ("b_felt",)),
    ("in free space {:.4g} kg and {:.3g} N s/m", ("mass_felt", "b_free")),
    ("first resonance {:.4g} Hz", ("first_peak_hz",)),
)


def answer(name: str, found: Transparency) -> dict[str, Any]:
    """Return the document of ``--json``."""
    return {
        "scenario": name,
        "user": found.user,
        "axis": found.axis + 1,
        "source": found.source,
        **dataclasses.asdict(found.rendered),
        "ideal": dataclasses.asdict(found.ideal),
        "notes": list(found.notes),
    }


def sentences(document: dict[str, Any]) -> list[str]:
    """Return the same for people."""
    found = []
    through = f"{document['user']}, through the link"
    for who, rendered in ((through, document), ("ideal", document["ideal"])):
        none = document["source"] == "model" and rendered["first_peak_hz"] is None
        text = rendered_words(rendered) or "unknown"
        found.append(f"{who}: {text}{', no resonance' if none else ''}")
    return found + [f"  {note}" for note in document["notes"]]


def rendered_words(found: Mapping[str, Any]) -> str:
    """Return what is known of a :class:`Rendering`, by name, in words."""
    rows = ((text, [found[name] for name in names]) for text, names in RENDERED)
    known = ((text, numbers) for text, numbers in rows if None not in numbers)
    return ", ".join(text.format(*(round(n, 4) + 0.0 for n in each)) for text, each in known)


def write(folder: Path, found: Transparency) -> Path:
    """Write all curves, complex ones in two parts, as CSV; return the file."""
    columns: dict[str, Array] = {}
    for key in CURVES:
        values = getattr(found, key)
        parts = {f"{key}_real": values.real, f"{key}_imag": values.imag}
        columns |= parts if np.iscomplexobj(values) else {key: values}
    folder.mkdir(parents=True, exist_ok=True)
    return write_table(folder / f"{NAME}.csv", columns)
