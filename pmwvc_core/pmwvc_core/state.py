# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The base of the plant's classes, until everything steps its laws."""


class Stateful:
    """A block with state."""

    __slots__ = ()
