#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Write ``docs/parameters.md`` from the parameter dataclasses: ``make docs``."""

from pathlib import Path

from pmwvc_core.runtime.reference import docs_table, reference_page
from pmwvc_core.simulation.scenario import DEFAULTS, SHARED_GROUPS, TOP, USER_GROUPS

PAGE = Path(__file__).resolve().parents[1] / "docs" / "parameters.md"
HEAD = """# Parameters

Dotted names, used alike in scenario files, `--set`, ROS parameters and reports. `user2.` in front of a name of the
second part means that user only; `link.delay_s` (directly below `link`) means both directions. This page is written
by `make docs`.

## What all users share
"""
EACH = """
## What each user has for itself

`side` (`user1.side`): -1 or 1, the side of the object a user is on; -1 pushes towards +x. Users alternate by default.
"""


def page() -> str:
    """Return the text of the reference page."""
    shared = {prefix: kind for prefix, (_, kind) in SHARED_GROUPS.items()}
    each = {prefix: kind for prefix, (_, kind) in USER_GROUPS.items()}
    parts = [HEAD, docs_table(TOP, DEFAULTS), reference_page(shared), EACH, reference_page(each)]
    return "\n".join(part.strip("\n") + "\n" for part in parts)


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
