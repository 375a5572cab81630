# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of a session as others see it, between ticks."""

from collections.abc import Sequence
from typing import Any

from pmwvc_core.ends.forms import value
from pmwvc_core.ends.inbox import Inbox
from pmwvc_core.frame.rows import FrameReport
from pmwvc_core.law.port.master import port_energies
from pmwvc_core.law.user_tick import User as Loop
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.numeric import Value
from pmwvc_core.scenario.scenario import User


class UserView:
    """What is read of a force loop: its state ``s``, parameters ``p`` and ``inbox``."""

    s: Loop
    p: Any
    inbox: Inbox
    _user: User
    _accounts: Sequence[str]

    @property
    def rate_drop(self) -> int:
        """Ticks of a frame."""
        return self.p.rate_drop  # type: ignore[no-any-return]

    @property
    def next_frame(self) -> int:
        """Tick with which the next frame starts."""
        return self.s.next_frame

    @property
    def ready(self) -> bool:
        """True once the server has answered and the soft start is over.

        From then on a simulated hand may act against the force that the controller renders;
        before, it would push the device away from its avatar against a force held back.
        """
        return self.s.limits.ready

    @property
    def coupled(self) -> bool:
        """Whether the server had answered and the soft start was over when an answer was taken."""
        return self.s.coupled

    @property
    def x(self) -> Value:
        """Last valid position [m]."""
        return value(self.s.x)

    @property
    def late_samples(self) -> int:
        """Ticks so far with an old sample, or none."""
        return self.s.late

    @property
    def other_controller(self) -> int:
        """Packets of another kind of controller, which are ignored."""
        return self.inbox.other_controller

    @property
    def max_force(self) -> float:
        """Longest force that the device is given [N]."""
        return self.p.limits.max_force  # type: ignore[no-any-return]

    @property
    def state(self) -> int:
        """State of the limits."""
        return int(state_of(self.s.limits.cause))

    @property
    def reason(self) -> str:
        """Why they are in that state."""
        return str(text_of(self.s.limits.cause, self._user.safety))

    @property
    def safety_events(self) -> int:
        """How often the limits intervened."""
        return self.s.limits.events

    def report(self) -> FrameReport:
        """Return safety state and energies as they are now."""
        s = self.s
        energies = port_energies(s.port, s.arrivals, self.p.port)
        accounts = dict(zip(self._accounts, energies[4:], strict=False))
        u_m, u_tx, v_rx, v_m = energies[:4]
        return FrameReport(self.state, self.reason, u_m, u_tx, v_rx, v_m, accounts)
