# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Notices beside the verdict: what happened to a running session that explains what is seen."""

from collections import deque
from collections.abc import Sequence

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.protocol.snapshot import Layout, Snapshot

STALL_S = 0.025  # of a loop: it then skips ticks, and a watchdog of 30 ms may let go
MOST = 4


class Notices:
    """The newest notices of a session."""

    def __init__(self) -> None:
        self._texts: deque[str] = deque(maxlen=MOST)
        self._time_s = 0.0

    def texts(self) -> list[str]:
        """Return the notices, oldest first."""
        return list(self._texts)

    def watch(self, snapshots: Sequence[Snapshot], layout: Layout, users: Sequence[str]) -> None:
        """Note the stalls of force loops in new snapshots."""
        for snapshot in snapshots:
            row = snapshot.row
            self._time_s = float(row[layout.slices["time_s"].start])
            for user in users:
                late_s = float(row[layout.slices[f"{user}.lateness"].start])
                if late_s > STALL_S:  # not where it is not known
                    self._note(
                        f"the machine stalled: the force loop of {user} woke "
                        f"{1e3 * late_s:.0f} ms late; beyond 30 ms its force and avatar begin anew"
                    )

    def changed(self, old: Scenario, new: Scenario) -> None:
        """Note a delay that grows under waves; samples of waves are held meanwhile."""
        pairs = [
            (getattr(before, way).delay_s, getattr(after, way).delay_s)
            for before, after in zip(old.users, new.users, strict=True)
            for way in ("link_up", "link_down")
        ]
        if has_waves(new.controller) and any(after > before for before, after in pairs):
            longest_s = max(after for _, after in pairs)
            text = f"the delay grew, to {1e3 * longest_s:.0f} ms"
            if new.channel == "plain":
                text += "; meanwhile waves are held, which can generate energy"
            self._note(text)

    def _note(self, text: str) -> None:
        self._texts.append(f"At {self._time_s:.1f} s {text}.")
