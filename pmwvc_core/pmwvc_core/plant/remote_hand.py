# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The hand whose target comes from outside: a person with a pointer, a file, another program.

Arm and grip are those of :mod:`.hand`. The newest target counts. The point x_t that the arm
follows moves towards it with at most ``speed_m_s``, and is never further than
``reach_n / stiffness`` from the arm::

    f_h = g [K (y - x) + B (yd - xd)] - (1 - g) brake xd
    m ydd = a k (x_t - y) - d yd - g [K (y - x) + B (yd - xd)]

A target that is not finite, none at all, or none for ``SILENT_S`` lets go: g and a fall to zero
within ``FADE_S`` while x_t rests. Then the handle is free and braked. A target that comes after
that takes hold: the arm begins at the handle, at rest, and g rises within ``TAKE_S``.

**Why this adds no energy.** With x_t at rest a falling stiffness only loses energy. While g rises,
arm and target move so that K g (y - x)^2/2 stays what it is. The sum S of :mod:`.hand` has the
terms - g (B + K T/2) T w^2/4 - (1 - g) brake T xd^2/4 here, of the forces held over a tick T. A
change of g changes them; that is part of ``effort_j``: letting go of a handle at w = 0.1 m/s, 20
microjoules. So the work on the device is at most ``effort_j`` and the sum of these terms.
"""

from collections.abc import Sequence
from typing import Protocol

from pmwvc_core.numeric import Value, clip, dot, finite, limit_length, squared
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.devices import along_first_axis
from pmwvc_core.plant.forces import Operator
from pmwvc_core.plant.hand import Grip, arm_step

SILENT_S = 0.15
FADE_S = 0.1
TAKE_S = 0.03
FARTHEST_M = 10.0  # targets beyond are taken to be there

Target = Value | None


class TargetSource(Protocol):
    """The source of a remote hand's targets."""

    early: bool  # whether it is asked before the user is coupled, too

    def take(self) -> Sequence[Target]:
        """Return the targets that came since the last call, a tick ago [m], in their order; None
        lets go.
        """
        ...


class NoTargets:
    """No target ever."""

    early = False

    def take(self) -> Sequence[Target]:
        """Return nothing."""
        return ()


class RemoteHand(Operator):
    """The five-parameter hand that follows targets from outside; the device is at ``start`` first,
    along axis 0 [m].
    """

    SIGNALS = "y yd target"
    MEMORY = "holding effort_j source _grip_ratio _arm_ratio _wanted _age"

    def __init__(self, params: OperatorParams, *, start: Value, tick_s: float, dof: int) -> None:
        super().__init__(tick_s=tick_s, dof=dof)
        arm = params.remote
        self._grip = Grip(params, arm_mass=arm.mass, tick_s=tick_s)
        self._stiffness, self._brake = arm.stiffness, arm.brake
        self._twice_mass = 2.0 * arm.mass
        self._resistance = 2.0 * arm.mass + tick_s * arm.damping
        self._step_m = arm.speed_m_s * tick_s
        self._reach_m = arm.reach_n / arm.stiffness
        self._silent_ticks = round(SILENT_S / tick_s)
        self._rise, self._fall = tick_s / TAKE_S, tick_s / FADE_S
        self.source: TargetSource = NoTargets()
        self.y: Value = along_first_axis(start, dof)  # [m] of the arm; of a free handle
        self.yd: Value = 0.0 * self.y  # [m/s]
        self.target: Value = self.y  # [m] that the arm follows; where a free handle is
        self.holding = False  # whether somebody holds the handle
        self.effort_j: Value = 0.0  # [J] of the moving target and of the changes of grip
        self._grip_ratio = self._arm_ratio = 0.0  # g, a
        self._wanted: Target = None
        self._age = 0  # ticks since it came

    def hold(self) -> Value:
        """Return the force while the user is not coupled: none; targets grow old."""
        if self.source.early:
            self._listen()
        return super().hold()

    def _listen(self) -> None:
        """Take the newest target; drop one that is too old."""
        self._age += 1
        for target in self.source.take():
            usable = target is not None and finite(target)
            self._wanted = target if usable else None
            self._age = 0
            self.holding = self.holding and usable
        if self._age > self._silent_ticks:
            self._wanted = None

    def _force(self, x: Value, xd: Value) -> Value:
        self._listen()
        if self._wanted is None:
            self.holding = False
        elif self._grip_ratio == self._arm_ratio == 0.0:
            self.holding, self._arm_ratio = True, 1.0
        self._change_grip(x, xd)
        grip = self._grip_ratio
        if grip == self._arm_ratio == 0.0:
            self.y, self.yd, self.target = x, 0.0 * xd, x
            return -self._brake * xd
        pull = grip * self._grip.force(self.y - x, self.yd - xd)
        self._move_arm(pull)
        return pull - (1.0 - grip) * self._brake * xd

    def _change_grip(self, x: Value, xd: Value) -> None:
        """Close or open the hand by a tick's part."""
        before = self._grip_ratio
        if self.holding:
            self._grip_ratio = after = min(1.0, before + self._rise)
            closer = (1.0 - (before / after) ** 0.5) * (x - self.y)
            self.y, self.target = self.y + closer, self.target + closer
        else:
            self._grip_ratio = after = max(0.0, before - self._fall)
            self._arm_ratio = max(0.0, self._arm_ratio - self._fall)
        if after != before:
            power = self._grip.rate * squared(self.yd - xd) - self._brake * squared(xd)
            self.effort_j = self.effort_j + 0.25 * self.tick_s * (before - after) * power

    def _move_arm(self, pull: Value) -> None:
        """Advance the arm by the implicit midpoint rule, the grip's pull held."""
        tick_s, y, yd, before = self.tick_s, self.y, self.yd, self.target
        if self.holding and self._wanted is not None:
            wanted = clip(self._wanted, -FARTHEST_M, FARTHEST_M)
            ahead = before + limit_length(wanted - before, self._step_m) - y
            self.target = y + limit_length(ahead, self._reach_m)
        step = self.target - before
        stiffness = self._arm_ratio * self._stiffness
        lead = before + 0.5 * step - y
        inertia = self._resistance + 0.5 * tick_s**2 * stiffness
        drive = stiffness * lead - pull
        moved, self.yd = arm_step(yd, drive, self._twice_mass, inertia, tick_s)
        self.effort_j = self.effort_j + dot(stiffness * (lead - 0.5 * moved), step)
        self.y = y + moved
