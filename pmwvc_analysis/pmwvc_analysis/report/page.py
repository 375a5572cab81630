# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One self-contained HTML page from a template of this folder; ``page_template.html`` has the
style.
"""

import base64
from pathlib import Path
from typing import Any

from pmwvc_analysis.charts.style import DARK, LIGHT, css_variables
from pmwvc_core.words import cell, quantity


def filled(template: str, **values: Any) -> str:
    """Return a template filled in; a name that it asks for and does not get is an error."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(cell=cell, quantity=quantity)
    colours = {"light": css_variables(LIGHT), "dark": css_variables(DARK)}
    return environment.get_template(template).render(**colours, **values)


def data_uri(path: Path) -> str:
    """Return a PNG as text that stands for the file."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
