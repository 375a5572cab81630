# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The answer of a transparency analysis: as plain numbers, in sentences, as files of arrays."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.arrays import write_table
from pmwvc_analysis.transparency.measured import TRUSTED, Admittance
from pmwvc_analysis.transparency.transparency import Transparency
from pmwvc_core.errors import file_errors
from pmwvc_core.numeric import Array, Complex

NAME = "transparency"
CURVES = ("frequency_hz", "admittance", "impedance", "ideal_admittance")
RENDERED = (  # what is known of it is told
    ("stiffness {:.4g} N/m", ("k_felt",)),
    ("damping {:.4g} N s/m", ("b_felt",)),
    ("in free space {:.4g} kg and {:.3g} N s/m", ("mass_felt", "b_free")),
    ("without the device {:.4g} kg and {:.3g} N s/m", ("mass_link", "b_link")),
    ("first resonance {:.4g} Hz", ("first_peak_hz",)),
)


def answer(
    name: str,
    found: Transparency,
    measured: Admittance | None = None,
    model: Complex | None = None,
) -> dict[str, Any]:
    """Return the document of ``--json``; ``model`` is that at the frequencies measured."""
    compared = None
    if measured is not None:
        trusted = measured.coherence >= TRUSTED
        error: Any = [] if model is None else np.abs(measured.admittance / model - 1.0)[trusted]
        compared = {
            "points": len(measured.frequency_hz),
            "trusted": int(trusted.sum()),
            "stretches": measured.stretches,
            "from_hz": float(measured.frequency_hz.min()),
            "to_hz": float(measured.frequency_hz.max()),
            "coherence_median": float(np.median(measured.coherence)),
            "error_median": float(np.median(error)) if len(error) else None,
        }
    return {
        "scenario": name,
        "user": found.user,
        "axis": found.axis + 1,
        "source": found.source,
        **dataclasses.asdict(found.rendered),
        "ideal": dataclasses.asdict(found.ideal),
        "measured": compared,
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
    if (seen := document["measured"]) is not None:
        error = "unknown" if seen["error_median"] is None else f"{seen['error_median']:.2%}"
        found.append(
            f"measured: {seen['points']} frequencies from {seen['from_hz']:.3g} to "
            f"{seen['to_hz']:.3g} Hz, median coherence {seen['coherence_median']:.3f}, median "
            f"deviation from the model {error}"
        )
    return found + [f"  {note}" for note in document["notes"]]


def rendered_words(found: Mapping[str, Any]) -> str:
    """Return what is known of a :class:`Rendering`, by name, in words."""
    rows = ((text, [found[name] for name in names]) for text, names in RENDERED)
    known = ((text, numbers) for text, numbers in rows if None not in numbers)
    return ", ".join(text.format(*(round(n, 4) + 0.0 for n in each)) for text, each in known)


def write(folder: Path, found: Transparency, measured: Admittance | None) -> list[Path]:
    """Write all curves, complex ones in two parts, as CSV; those measured have their own."""
    tables = {NAME: {key: getattr(found, key) for key in CURVES}}
    if measured is not None:
        keys = ("frequency_hz", "admittance", "coherence")
        tables[f"{NAME}_measured"] = {f"measured_{key}": getattr(measured, key) for key in keys}
    with file_errors(f"write into {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for name, curves in tables.items():
            columns: dict[str, Array] = {}
            for key, values in curves.items():
                parts = {f"{key}_real": values.real, f"{key}_imag": values.imag}
                columns |= parts if np.iscomplexobj(values) else {key: values}
            paths.append(write_table(folder / f"{name}.csv", columns))
    return paths
