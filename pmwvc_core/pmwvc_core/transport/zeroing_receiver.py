# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver of the zeroing channel: every wave counts for one step, and where none has come the
wave is zero.

A wave given out for one step of the length that its packet stands for brings no more energy than
the packet carried, whatever is lost, late, repeated or out of order. The displacement of what did
not come in time is lost.

Equations: docs/theory.md 3.4.
"""

from pmwvc_core.numeric import Value
from pmwvc_core.transport.receiver import Receiver


class ZeroingReceiver(Receiver):
    """The receiving end of one direction of the zeroing channel; see the module."""

    def take(self, now_ns: int) -> Value:
        """Return the newest wave [sqrt(W)] if it came since the last call; zero otherwise."""
        fresh = self._waiting > 0
        wave = super().take(now_ns)
        return wave if fresh else 0.0 * wave
