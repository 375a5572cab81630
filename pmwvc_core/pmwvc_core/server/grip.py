# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The one-sided contact along one axis: an avatar pushes the face of its own side and never pulls.

With the depth ``p`` of the avatar in the face (negative outside) and the inward direction n =
-side::

    N = max(0, K p + B p')  while p > 0, else 0        force on the object: f = n N

Over a whole step from p0 to p1 = p0 + h w the mean force that neither makes nor loses energy is
the difference quotient of the potential phi(p) = K max(p, 0)^2 / 2, and the damper acts on the
part of the way inside::

    N = max(0, [phi(p1) - phi(p0)] / (p1 - p0) + B [max(p1, 0) - max(p0, 0)] / h)

N never falls with w, so together with w = free - N/b it has exactly one solution, piece by piece a
quadratic. Where N is held at zero the spring only relaxes: its energy is lost, none is made.

Where stiffness changes in contact, the face counts as shifted (see ``contacts``). Outside the
contact it goes back, never past the avatar, so without force and energy.

Not here: the tangential directions (``friction``).

Equations: docs/theory.md 4.3.
"""

from pmwvc_core.numeric import Flag, Value, anywhere, maximum, minimum, root, where
from pmwvc_core.server.contacts import Answer, kept
from pmwvc_core.state import Stateful


def _nonzero(value: Value) -> Value:
    """Return a divisor for a branch that will not be chosen where the value is zero.

    What is divided by must not be a square: squares of small depths vanish before the depths do.
    """
    return where(value > 0.0, value, 1.0)


class Grip(Stateful):
    """One-sided spring and damper at the face ``side`` * ``size``/2 from the object's centre."""

    SIGNALS = "deflection"
    MEMORY = "rest _shifted"

    def __init__(
        self, stiffness: Value, damping: Value, *, side: int, size: Value, gap: Value = 0.0
    ) -> None:
        self.stiffness = stiffness  # [N/m]
        self.damping = damping  # [N s/m]
        self.inward = -float(side)
        self.gap = gap  # [m] least distance from the face at the start
        self._face: Value = 0.5 * side * size  # [m] from the centre
        self.rest = self._face  # [m] where it counts as being
        self._shifted = False
        self.deflection: Value = self.inward * 0.0  # [m], from the face

    @property
    def position(self) -> Value:
        """Position of the avatar, from the object's centre [m]."""
        return self.rest + self.deflection

    @property
    def depth(self) -> Value:
        """Depth of the avatar inside the face; negative outside [m]."""
        return self.inward * self.deflection

    @property
    def touching(self) -> Flag:
        """True where the avatar is inside the face."""
        return self.depth > 0.0

    @property
    def energy(self) -> Value:
        """Energy of the spring, K max(p, 0)^2 / 2 [J]."""
        return self._stored(self.depth)

    def _stored(self, depth: Value) -> Value:
        inside = maximum(depth, 0.0)
        return 0.5 * self.stiffness * inside * inside

    def attach(self, offset: Value) -> None:
        """Begin at ``offset``, but at least the gap outside the face."""
        self.rest, self._shifted = self._face, False
        wanted = self.inward * (offset - self.rest)
        self.deflection = self.inward * minimum(wanted, -self.gap)

    def detach(self) -> Value:
        """Let go; return the energy dropped."""
        dropped = self.energy
        self.deflection = self.inward * minimum(self.depth, 0.0)
        return dropped

    def configure(self, stiffness: Value, damping: Value) -> Value:
        """Keep energy and position; return what is lost."""
        before, depth = self.energy, self.depth
        stood = self.position
        inside = kept(depth, self.stiffness, stiffness)
        self.deflection = self.inward * where(depth > 0.0, inside, depth)
        self.rest, self._shifted = stood - self.deflection, True
        self.stiffness, self.damping = stiffness, damping
        self._return()
        return before * where(stiffness > 0.0, 0.0, 1.0)

    def _return(self) -> None:
        """Shift the face back where it is not touched, at most to the avatar."""
        inward, outside = self.inward, maximum(-self.depth, 0.0)
        shift = inward * (self.rest - self._face)
        back = where(self.depth > 0.0, 0.0, minimum(shift, outside))
        self.deflection = self.deflection + inward * back
        left = where(back == shift, 0.0, shift - back)
        self.rest = self._face + inward * left
        self._shifted = anywhere(left != 0.0)

    def force(self, rate: Value) -> Value:
        """Return n max(0, K p + B p') inside the face, else 0."""
        depth = self.depth
        normal = maximum(self.stiffness * depth + self.damping * (self.inward * rate), 0.0)
        return self.inward * where(depth > 0.0, normal, 0.0)

    def heat(self, rate: Value) -> Value:
        """Return B p'^2 while the contact pushes, else 0."""
        return where(self.inward * self.force(rate) > 0.0, self.damping * rate * rate, 0.0)

    def unwrapped(self, free: Value, xd_o: Value, impedance: Value, weight: Value) -> Value:
        """Return the force that keeps the avatar inside and pushes, else 0.

        The sampled law jumps where the damper begins to act, so contact begins only once the
        avatar ends inside although it is pushed back.
        """
        gain = self.damping + weight * self.stiffness
        inward = self.inward
        loose = self.stiffness * self.depth + inward * (gain * free - self.damping * xd_o)
        normal = loose / (1.0 + gain / impedance)
        depth = self.depth + weight * (inward * free - normal / impedance)
        return inward * where((normal > 0.0) & (depth > 0.0), normal, 0.0)

    def slide(self, displacement: Value) -> Value:
        """Move relative to the face; nothing is dropped, the spring follows the avatar out."""
        self.deflection = self.deflection + displacement
        if self._shifted:
            self._return()
        return 0.0

    def clear(self, displacement: Value) -> Value:
        """Return what of it ends at least the gap outside the face; zero in contact."""
        most = maximum(-self.depth - self.gap, 0.0)
        return where(self.touching, 0.0, self.inward * minimum(self.inward * displacement, most))

    def answer(self, free: Value, impedance: Value, period: Value) -> Answer:
        """Solve the mean law above together with w = free - f/impedance."""
        inward = self.inward
        p0, c = inward * self.deflection, inward * free
        inside = p0 > 0.0
        normal, rate, slope = self._staying(p0, c, impedance, period)
        leaves = inside & ((p0 + period * rate >= 0.0) ^ True)
        enters = (inside ^ True) & (p0 + period * c > 0.0)
        normal = where(inside, normal, 0.0)
        if anywhere(leaves):
            push, w, fall = self._leaving(p0, c, impedance, period)
            normal, rate = where(leaves, push, normal), where(leaves, w, rate)
            slope = where(leaves, fall, slope)
        if anywhere(enters):
            push, w, fall = self._entering(p0, c, impedance, period)
            normal, rate = where(enters, push, normal), where(enters, w, rate)
            slope = where(enters, fall, slope)
        pushes = normal > 0.0
        return Answer(
            inward * where(pushes, normal, 0.0),
            inward * where(pushes, rate, c),
            where(pushes, slope / (1.0 + slope / impedance), 0.0),
        )

    def meet(self, rate: Value, period: Value) -> Answer:
        """Return the mean law above for a given w."""
        p0, w = self.depth, self.inward * rate
        p1 = p0 + period * w
        in0, in1 = maximum(p0, 0.0), maximum(p1, 0.0)
        way = where(p1 > p0, p1 - p0, p0 - p1)
        ratio = where((p0 >= 0.0) & (p1 >= 0.0), 1.0, maximum(in0, in1) / _nonzero(way))
        normal = ratio * (0.5 * self.stiffness * (in0 + in1) + self.damping * w)
        spring = 0.5 * self.stiffness * period * ratio
        entering = spring * (2.0 - ratio) + self.damping
        slope = where(p1 > 0.0, entering, spring * ratio)
        pushes = normal > 0.0
        return Answer(self.inward * where(pushes, normal, 0.0), rate, where(pushes, slope, 0.0))

    def _staying(self, p0: Value, c: Value, b: Value, h: Value) -> tuple[Value, Value, Value]:
        """Inside at both ends: N = K p0 + (K h/2 + B) w. Returns N, w, dN/dw."""
        gain = 0.5 * self.stiffness * h + self.damping
        ratio = 1.0 + gain / b
        pull = self.stiffness * p0
        return (pull + gain * c) / ratio, (c - pull / b) / ratio, gain

    def _leaving(self, p0: Value, c: Value, b: Value, h: Value) -> tuple[Value, Value, Value]:
        """Inside at the start only: N = K p0^2/(2 h s) - B p0/h, s = -w, s^2 + beta s = gamma."""
        beta = c + self.damping * p0 / (h * b)
        gamma = 0.5 * self.stiffness * p0 * p0 / (h * b)
        length = root(beta * beta + 4.0 * gamma)
        speed = where(beta > 0.0, 2.0 * gamma / _nonzero(beta + length), 0.5 * (length - beta))
        ratio = p0 / _nonzero(h * speed)  # of the way that is inside
        normal = 0.5 * self.stiffness * p0 * ratio - self.damping * p0 / h
        return normal, -speed, 0.5 * h * self.stiffness * ratio * ratio

    def _entering(self, p0: Value, c: Value, b: Value, h: Value) -> tuple[Value, Value, Value]:
        """Inside at the end only: p1 is the positive root of a p^2 - 2 k p = g, g >= 0.

        The depth without resistance, p0 + h c > 0, is the only small difference in it.
        """
        reach = maximum(p0 + h * c, 0.0)
        a = b + 0.5 * h * self.stiffness + self.damping
        k = 0.5 * ((b + self.damping) * p0 + b * reach)
        g = -b * reach * minimum(p0, 0.0)
        length = root(k * k + a * g)
        p1 = where(k > 0.0, (k + length) / a, g / _nonzero(length - k))
        way = _nonzero(p1 - p0)
        ratio = p1 / way  # of the way that is inside
        normal = 0.5 * self.stiffness * p1 * ratio + self.damping * p1 / h
        slope = 0.5 * h * self.stiffness * ratio * (2.0 - ratio) + self.damping
        return normal, way / h, slope

    def advance(self, answer: Answer, period: Value) -> Value:
        """Move by the mean rate; return the damper's heat or, where N is zero, spring loss."""
        inward, rate = self.inward, answer.rate
        before = inward * self.deflection
        self.deflection = deflection = self.deflection + period * rate
        after = inward * deflection
        if self._shifted:
            self._return()
        pushes = inward * answer.force > 0.0
        way_inside = maximum(after, 0.0) - maximum(before, 0.0)
        heat = self.damping * way_inside * (inward * rate)
        if pushes is True:
            return heat
        return where(pushes, heat, self._stored(before) - self._stored(after))
