# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What an end of the channel needs of its receiver."""

from typing import Protocol

from pmwvc_core.numeric import Flag, Value


class Inbox(Protocol):
    """The receiving side of one direction: a receiver, or in a batch several of them side by side."""

    def take(self, now_ns: int) -> Value:
        """Return the newest wave, zero before the first packet."""

    def position(self) -> Value:
        """Return the position that came with it [m]."""

    def silent(self, now_ns: int) -> Flag:
        """Tell whether the other end has been silent for too long (also before its first packet)."""

    def silence_s(self, now_ns: int) -> Value:
        """Return the time since the last accepted packet [s]; infinite before the first."""

    def heard(self) -> Flag:
        """Tell whether any packet was ever accepted."""

    def echo(self, now_ns: int) -> tuple[int, int, int]:
        """Return sequence number, sender's clock and holding time [ns] of the newest packet."""
