# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The perceptual deadband of a sender: a wave that differs too little from the one sent last to be
felt needs no packet of its own.

With w the wave of a frame and w_sent that of the last packet (Hinterseer et al., 2008; by Weber's
law a hand tells two forces apart by their ratio)::

    held back where  |w - w_sent| <= ratio |w_sent|

unless the next packet would then stand for more than the longest time allowed: a sender that has
nothing new stays distinguishable from one that is gone. On the strict channel this costs neither
displacement nor energy, since the next packet carries the integral of all, but time: the receiver
has nothing to play meanwhile.

Equations: docs/theory.md 17.11.
"""

from pmwvc_core.numeric import Value, anywhere, squared
from pmwvc_core.params import DeadbandParams
from pmwvc_core.state import Stateful

ROUNDING = 1e-9  # of times, relative
OFF = DeadbandParams()


class Deadband(Stateful):
    """See the module; off by default."""

    MEMORY = "_sent"

    def __init__(self, params: DeadbandParams = OFF) -> None:
        self._sent: Value | None = None
        self.configure(params)

    def configure(self, params: DeadbandParams) -> None:
        """Take other parameters over."""
        self.params = params
        self.on = params.is_on
        self._longest_s = params.longest_s * (1.0 + ROUNDING)

    def holds_back(self, wave: Value, held_s: float, period_s: float) -> bool:
        """Tell whether a frame needs no packet, given its wave [sqrt(W)], float or ``(..., dof)``,
        the time of the frames held back before it [s], and its own [s].
        """
        sent = self._sent
        if not self.on or sent is None or held_s + 2.0 * period_s > self._longest_s:
            return False
        felt = squared(wave - sent) > self.params.ratio**2 * squared(sent)
        return not anywhere(felt)

    def sent(self, wave: Value) -> None:
        """Note the wave of a packet that is sent [sqrt(W)]."""
        self._sent = wave
