# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of the position between the counts of an encoder, written from theory.md 17.6,
17.9 and 17.21, one object per axis.
"""


def within(value, low, high):
    return min(max(value, low), high)


class Axis:
    """What one axis takes a count for, and where it is between two of them."""

    def __init__(self, h):
        self.h, self.count, self.follows = h, 1.0, False
        self.x = self.seen = self.edge = self.off = self.xd = 0.0
        self.still_s, self.slow_s = 0.0, 0.1

    @property
    def fine(self):
        """Whether the smallest step seen is no encoder's."""
        return self.count < 1e-7

    @property
    def coarse(self):
        """The count in force, zero before any was seen."""
        return 0.0 if self.fine or self.count >= 1.0 else self.count

    @property
    def rough(self):
        """The count, where the velocity is its jump."""
        return self.count if self.follows else 0.0

    def begin(self, x):
        self.x = self.seen = self.edge = x

    def see(self, x):
        """Return the jump of the position, which may be the smallest one so far."""
        jump, self.seen = x - self.seen, x
        if jump != 0.0:
            self.count = min(self.count, abs(jump))
        return jump

    def plain(self, x, xd, jump):
        """A tick in which all axes are exact: what moved, for the wave and for the work."""
        dx, self.x, self.edge, self.xd = x - self.x, x, x, xd
        self.still_s = 0.0 if jump else self.still_s + self.h
        self.slow_s = 0.0 if jump else self.slow_s + self.h
        return dx, jump

    def track(self, x, xd, jump):
        """The same behind counts."""
        q, h, before = self.coarse, self.h, self.x
        if jump or xd:
            self.follows = bool(q) and abs(xd * h - jump) <= 1e-6 * abs(jump)
        expected = before + (self.xd if self.follows else xd) * h
        error = x - expected
        if not self.follows:
            error -= within(error, -0.5 * q, 0.5 * q)
        self.still_s = 0.0 if jump else self.still_s + h
        self.slow_s = 0.0 if abs(jump) > 1.5 * q else self.slow_s + h
        self.xd = self._velocity(error, jump, q) if self.follows else xd
        found = expected + (0.72 if self.follows else 0.3) * error
        self.x = within(found, x - q, x + q)
        self.edge = within(self.edge, x - 0.5 * q, x + 0.5 * q)
        slow = self.follows and self.slow_s >= 0.1
        off = self.x + 0.3 * (self.edge - self.x) - x if slow else 0.0
        moved, self.off = jump + off - self.off, off
        return self.x - before, moved

    def _velocity(self, error, jump, q):
        """17.21: it grows only with a count and in its direction."""
        fastest = (q + abs(jump)) / max(self.still_s, self.h)
        wanted = within(self.xd + 0.2 / self.h * error, -fastest, fastest)
        if jump:
            return wanted if jump * wanted > 0.0 else 0.0
        return within(wanted, min(self.xd, 0.0), max(self.xd, 0.0))


class Encoder:
    """All axes of a device."""

    def __init__(self, dof, h):
        self.axes = [Axis(h) for _ in range(dof)]
        self.exact = self.counted = False

    def begin(self, x):
        for axis, value in zip(self.axes, x, strict=True):
            axis.begin(value)

    def step(self, x, xd):
        """Return what moved for the wave, for the work, and the velocity for the force."""
        jumps = [axis.see(value) for axis, value in zip(self.axes, x, strict=True)]
        self.counted = not self.exact and (self.counted or any(axis.coarse for axis in self.axes))
        found = []
        for axis, *values in zip(self.axes, x, xd, jumps, strict=True):
            found.append(axis.track(*values) if self.counted else axis.plain(*values))
        self.exact = self.exact or all(axis.fine for axis in self.axes)
        return *zip(*found, strict=True), [axis.xd for axis in self.axes]
