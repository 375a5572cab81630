# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ratios of a force that the safety limits let through: soft start, damping, release.

The ratio of the whole force rises from zero over ``soft_start_s`` and falls over ``LET_GO_S`` on
release. While only damping is rendered, the ratio of what does not oppose the motion fades over
``FADE_S``. When a state of damping ends, the force goes on from what had not faded yet: a pause
just over the timeout costs no grip, and one longer than ``FADE_S`` begins at zero. After a silence
of the same server it rises within ``RETURN_S`` (with a brake it is whole at once).
"""

from pmwvc_core.master.safety.states import Seen
from pmwvc_core.numeric import Flag, Value, dot, maximum, minimum, where
from pmwvc_core.params import SafetyParams
from pmwvc_core.state import Stateful

FADE_S, LET_GO_S = 0.02, 0.5
RETURN_S = 0.1  # after a silence of the same server: meanwhile the hand runs ahead


class Fading(Stateful):
    """See the module.

    Parameters
    ----------
    params
        The limits; numbers may be ``(runs, 1)``.
    tick_s
        Period of the force loop [s].
    whole
        Whether the force comes back whole after a silence: a brake holds the hand meanwhile.

    Attributes
    ----------
    gain
        Ratio of the force that is let through.
    ready
        Whether the force has ever been let through in full.
    """

    MEMORY = "gain ready _push _damped _returns"

    def __init__(self, params: SafetyParams, *, tick_s: float, whole: bool) -> None:
        self._tick_s = tick_s
        self._whole = whole
        self.configure(params)
        self.gain: Value = 0.0
        self.ready: Flag = False
        self._push: Value = 1.0
        self._damped: Flag = False
        self._returns: Flag = False  # rises after a silence of the same server

    def configure(self, params: SafetyParams) -> None:
        """Take other limits over; the ratios go on from where they are."""
        self._rise = self._tick_s / params.soft_start_s
        self._return = self._tick_s / minimum(params.soft_start_s, RETURN_S)

    def restart(self) -> None:
        """Let the force start from zero again."""
        self.gain = 0.0 * self.gain
        self._returns = False

    def step(self, through: Flag, damped: Flag, fast: Flag, released: Flag, before: Seen) -> None:
        """Go one tick on.

        Parameters
        ----------
        through
            Whether a force is let through at all.
        damped, fast
            Whether only damping is rendered; whether because of the speed, so that what pushes
            goes at once.
        released
            Whether the damping is let go.
        before
            What the limits saw in the tick before.
        """
        recovers = self._damped & (damped ^ True)
        quiet = before.silent & ((before.fast | before.outside) ^ True) & self.ready
        self._returns = ((recovers & quiet) | ((recovers ^ True) & self._returns)) & through
        rise = where(self._returns, self._return, self._rise)
        faded = recovers & ((quiet & self._whole) ^ True)
        gain = where(faded, self.gain * self._push, self.gain)
        less, more = maximum(gain - self._tick_s / LET_GO_S, 0.0), minimum(gain + rise, 1.0)
        gain = where(released, less, more)
        self.gain = gain = where(through, gain, 0.0)
        self.ready = self.ready | ((gain >= 1.0) & (damped ^ True))
        self._damped = damped
        fading = maximum(self._push - self._tick_s / FADE_S, 0.0)
        self._push = where(damped, where(fast, 0.0, fading), 1.0)

    def damping(self, f: Value, xd: Value, speed: Value) -> Value:
        """Return the part of a force that opposes the motion, and what is left of the rest [N].

        Parameters
        ----------
        f, xd
            Force [N] and velocity [m/s].
        speed
            |xd|^2 [m^2/s^2].
        """
        power = dot(f, xd)
        opposes = (power > 0.0) & (speed > 0.0)
        kept = where(opposes, xd * (power / where(opposes, speed, 1.0)), 0.0)
        return kept + self._push * (f - kept)
