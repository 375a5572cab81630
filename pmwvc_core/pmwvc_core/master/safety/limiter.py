# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits between any controller and the device. Research software: not a certified safeguard.

What reaches the device, for whatever a controller asks, including values that are not numbers:

* the force starts at zero, never changes by more than ``max_slew * tick_s`` in a tick and is never
  longer than ``max_force`` (a vector keeps its direction);
* whenever there is something to feel again (first answer, another server, any other recovery) it
  grows from zero over ``soft_start_s``, or after a silence from what had not faded (``fading``);
* **damping**: when the server has been silent for longer than ``timeout_s`` or three packets, or
  the device is faster than ``damper_velocity``, only the part of the force that opposes the motion
  remains; what pushes fades (at once above the speed). After ``release_s`` of silence the damping
  itself, and the brake, are let go;
* **workspace**: beyond the half extent that the device declares, damping likewise;
* **device silent**: while the device senses nothing there is no force at all (it is unknown how it
  moves); after ``LOST_S`` that is a fault, which ends with the next sample;
* a value that is not a finite number counts as a force of zero;
* **fault**: above ``fault_velocity`` the force goes to zero and stays there until ``rearm``.

Everything that is a limit on the force is also a limit on its way to zero: letting go is fast, but
never a step. Works on floats and on arrays; in a batch every run has its own state.

A tick is inactive when all of that leaves the force unchanged in every run; after one, a few
comparisons tell whether the next one is, too.

Equations: docs/theory.md 10.2.
"""

from pmwvc_core.master.brake import HandBrake
from pmwvc_core.master.safety.fading import Fading
from pmwvc_core.master.safety.states import (
    Cause,
    Integers,
    Interventions,
    Seen,
    cause_of,
    state_of,
    text_of,
)
from pmwvc_core.numeric import (
    LARGEST,
    Flag,
    Value,
    limit_length,
    minimum,
    root,
    squared,
    truth,
    where,
    within,
)
from pmwvc_core.params import SafetyParams
from pmwvc_core.state import Stateful

LOST_S = 1.0
REACH = 1.01  # of the workspace: a stop gives way a little
ROUNDING = 1.0 - 1e-12  # of a squared limit: below it the length is inside, however rounded


class SafetyLimiter(Stateful):
    """See the module. One object per device; the owner calls ``step`` every tick.

    Parameters
    ----------
    params
        The limits; numbers may be ``(runs, 1)``.
    tick_s
        Period of the force loop [s].
    packet_s
        Interval at which the server answers [s].
    workspace_m
        Half extent of the device's workspace on every axis [m]; unlimited where not declared.
    brake
        What holds the hand while no waves come (strict channel); the server is silent only once
        nothing is at hand any more.

    Attributes
    ----------
    f
        Force as applied last [N].
    inactive
        Whether the last tick let the force through unchanged.
    """

    BLOCKS = "_brake _fading _interventions"
    MEMORY = "f inactive _missing_s _sensed _faulty _seen"

    def __init__(
        self,
        params: SafetyParams,
        *,
        tick_s: float,
        packet_s: float,
        workspace_m: float | None = None,
        brake: HandBrake | None = None,
    ) -> None:
        self._brake, self._tick_s, self._packet_s = brake, tick_s, packet_s
        self._reach = LARGEST if workspace_m is None else REACH * workspace_m
        self._missing_s: Value = 0.0  # time without a sample of the device
        self._sensed: Flag = False  # ever
        self._fading = Fading(params, tick_s=tick_s, whole=brake is not None)
        self.configure(params)
        self.f: Value = 0.0
        self._faulty: Flag = False
        self.inactive = False
        self._interventions, self._seen = Interventions(), Seen()

    def configure(self, params: SafetyParams) -> None:
        """Take other limits over; state and force go on from where they are."""
        self.params = params
        self._fading.configure(params)
        self._silence_s = max(params.timeout_s, 3.0 * self._packet_s)
        self._slew = params.max_slew * self._tick_s
        self._too_fast, self._runaway = params.damper_velocity**2, params.fault_velocity**2
        self._longest = params.max_force**2
        self._slow = ROUNDING * minimum(self._too_fast, self._runaway)
        self._weak, self._gentle = ROUNDING * self._longest, ROUNDING * self._slew**2

    def expect(self, silence_s: float) -> None:
        """Note how long packets may fail to come before the server counts as silent [s]."""
        self._silence_s = max(self.params.timeout_s, 3.0 * self._packet_s, silence_s)

    def rearm(self) -> None:
        """Leave a fault; the force starts from zero again."""
        self._faulty = self._faulty & False

    def restart(self) -> None:
        """Let the force start from zero again: what it comes from is not what it came from."""
        self._fading.restart()
        self.inactive = False
        self._seen = Seen()
        if self._brake:
            self._brake.reset()

    def step(
        self,
        f_asked: Value,
        x: Value,
        xd: Value,
        silence_s: Value,
        coupled: Flag,
        sensed: Flag = True,
        interrupted: Flag = False,
        unreceived: Flag = False,
    ) -> Value:
        """Return the force for the device [N].

        Parameters
        ----------
        f_asked
            What the controller asks for [N], ``(..., dof)``.
        x, xd
            Measured position [m] and velocity [m/s].
        silence_s
            Time since the last accepted packet [s], one per run.
        coupled
            Whether the server has ever answered.
        sensed
            Whether the device knows where it is and how it moves.
        interrupted
            Whether no waves come, at this end or at the server.
        unreceived
            Whether the server has had none of this user for too long.
        """
        brake, idle = self._brake, True
        if brake:
            idle = brake.step(interrupted, x, self.f)
        if self.inactive and idle and not unreceived:
            inside = (  # comparisons with NaN are False, so NaN takes the slow path
                coupled
                & sensed
                & (silence_s <= self._silence_s)
                & (squared(xd) <= self._slow)
                & (squared(f_asked) <= self._weak)
                & (squared(f_asked - self.f) <= self._gentle)
                & (-self._reach < x < self._reach if type(x) is float else within(x, self._reach))
            )
            if inside is True or (inside is not False and truth(inside)):
                self.f = f_asked
                return f_asked
        good = within(f_asked, LARGEST) & within(x, LARGEST) & within(xd, LARGEST)
        if good is not True:
            f_asked, xd = where(good, f_asked, 0.0), where(good, xd, 0.0)
        speed = squared(xd)
        self._sensed = self._sensed | sensed
        self._missing_s = where(sensed, 0.0, self._missing_s + self._tick_s)
        lost = coupled & (self._missing_s > LOST_S)
        gone = coupled & (sensed ^ True) & (self._sensed | lost)
        active = coupled & sensed
        silent = active & (silence_s > self._silence_s)
        if brake:
            silent = silent & (interrupted | (silence_s > self.params.release_s))
        fast = active & (speed > self._too_fast)
        self._faulty = faulty = self._faulty | (active & (speed > self._runaway))
        outside = active & (within(x, self._reach) ^ True)
        damped = silent | fast | outside
        released = silent & (silence_s > self.params.release_s)
        through, fading = active & good & (faulty ^ True), self._fading
        fading.step(through, damped, fast, released, self._seen)
        if damped is not False:
            f_asked = where(damped, fading.damping(f_asked, xd, speed), f_asked)
        if brake and not idle:
            f_asked = f_asked + where(fast | outside, 0.0, brake.force(f_asked))
        applied, limited = self._limit(f_asked * fading.gain)
        unreceived = unreceived & active
        disturbed = gone | (active & (damped | unreceived | (through ^ True)))
        self._interventions.step(disturbed, limited & through & (damped ^ True))
        late = brake.holds if brake else False
        self._seen = Seen(
            active, good, faulty, silent, released, fast, outside, gone, lost, unreceived, late
        )
        quiet = (damped | limited | unreceived | late) ^ True
        self.inactive = truth(through & quiet & (fading.gain >= 1.0))
        return applied

    @property
    def ready(self) -> Flag:
        """Whether the force has ever been let through in full: a simulated hand may act."""
        return self._fading.ready

    @property
    def state(self) -> int | Integers:
        """The present ``SafetyState``; in a batch an array ``(runs, 1)``."""
        return state_of(self._cause())

    @property
    def reason(self) -> str | list[str]:
        """Why, empty when coupled; in a batch one text per run."""
        return text_of(self._cause(), self.params)

    def _cause(self) -> int | Integers:
        if self.inactive and type(self._fading.gain) is float:
            return Cause.NONE
        return cause_of(self._seen, self._fading.gain)

    @property
    def events(self) -> int | Integers:
        """Number of interventions so far; in a batch ``(runs, 1)``."""
        return self._interventions.count

    def _limit(self, f: Value) -> tuple[Value, Flag]:
        """Limit the force, then its change; also return whether either was limited."""
        wanted = limit_length(f, self.params.max_force)
        change = wanted - self.f
        length = root(squared(change))
        slewed = length > self._slew
        part = change * (self._slew / where(slewed, length, 1.0))
        self.f = where(slewed, self.f + part, wanted)
        return self.f, slewed | (squared(f) > self._longest)
