# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of things in sentences."""


def count(number: int, thing: str) -> str:
    """Return a number of things: ``1 user``, ``2 users``."""
    return f"{number} {thing}{'' if number == 1 else 's'}"
