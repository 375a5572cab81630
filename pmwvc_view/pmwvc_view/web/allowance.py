# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of messages that a page may send: a mean rate, and as many at once."""


class Allowance:
    """Messages that a page may still send.

    Parameters
    ----------
    rate_hz
        Mean rate; as many as come in a second may come at once.
    now_s
        Present time of any clock [s].
    """

    def __init__(self, rate_hz: float, now_s: float) -> None:
        self._rate_hz = self._left = rate_hz
        self._at_s = now_s

    def spend(self, now_s: float) -> bool:
        """Count one message; return whether it is allowed."""
        self._left = min(self._rate_hz, self._left + (now_s - self._at_s) * self._rate_hz)
        self._at_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
