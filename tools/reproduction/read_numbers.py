# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Readers of the numbers that claims compare with."""

from collections.abc import Callable

from reproduction.claim import Numbers

Read = Callable[[Numbers], float | None]


def number(figure: str, name: str) -> Read:
    """Return a reader of one number."""

    def read(numbers: Numbers) -> float | None:
        value: float | None = numbers[figure][name]
        return value

    return read


def ratio(above: Read, below: Read) -> Read:
    """Return a reader of a quotient; None where there is none."""

    def read(numbers: Numbers) -> float | None:
        top, bottom = above(numbers), below(numbers)
        return None if top is None or not bottom else top / bottom

    return read


def channel(figure: str, impedance: int, contact: float, prefix: str = "") -> Read:
    """Return a reader of the channel's stiffness, in series with the contact's."""

    def read(numbers: Numbers) -> float | None:
        felt: float = numbers[figure][f"{prefix}k_felt_b_{impedance}"]
        return 1.0 / (1.0 / felt - 1.0 / contact)

    return read
