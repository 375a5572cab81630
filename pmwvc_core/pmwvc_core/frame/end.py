# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The common part of both ends of the frame protocol: changes handed over from other threads, and
the refusal of packets of another kind of controller.
"""

from collections import deque
from collections.abc import Callable

from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_DIRECT, FLAG_WAITING, WavePacket
from pmwvc_core.transport.receiver import Receiver


class ProtocolEnd(Stateful):
    """One end of the frame protocol.

    Attributes
    ----------
    other_controller
        Packets of another kind of controller, which are ignored.
    changes
        Frames or steps that took changes over.
    """

    MEMORY = "other_controller changes"

    def __init__(self) -> None:
        self.other_controller = 0
        self.changes = 0
        self._changes: deque[Callable[[], None]] = deque()

    def hand_over(self, change: Callable[[], None]) -> None:
        """Have a change made before the server's next step, or at the next frame start behind the
        master's packet; from any thread.
        """
        self._changes.append(change)

    def _take_changes(self) -> None:
        """Make the changes that were handed over."""
        if self._changes:
            self.changes += 1
        while self._changes:
            self._changes.popleft()()

    def _refuses(self, packet: WavePacket, flags: int) -> bool:
        """Tell, and count, whether a packet is for another kind of controller than the one whose
        packets have these flags.
        """
        if not (packet.flags ^ flags) & FLAG_DIRECT or packet.refusal is not None:
            return False
        self.other_controller += 1
        return True


def waiting(inbox: Receiver) -> int:
    """Return the flag of packets from an end to which no waves come."""
    return FLAG_WAITING if inbox.playout.waits else 0
