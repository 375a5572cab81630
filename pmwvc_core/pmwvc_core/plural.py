# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and lists of things in sentences."""

from collections.abc import Sequence


def count(number: int, thing: str) -> str:
    """Return a number of things: ``1 user``, ``2 users``."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def listed(texts: Sequence[str], last: str = "and") -> str:
    """Return texts as a list in a sentence: ``a``, ``a and b``, ``a, b and c``."""
    if len(texts) < 2:
        return "".join(texts)
    return f"{', '.join(texts[:-1])} {last} {texts[-1]}"
