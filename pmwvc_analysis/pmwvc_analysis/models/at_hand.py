# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The time that the server's playouts have at hand over a constant delay.

The model of a playout is linear for a given least time at hand m, the time of waves left over
behind the step of a hyperperiod that has the least. Signals do not enter it, but the beginning and
energy do: what a user's first packets meet, how much lag its first waits leave (margin, slow
return), and whether there was free energy to catch up from 3 s on. So m is followed with the
core's own playout, begun at every step of a hyperperiod, with no free energy, with ample energy,
and with ample energy once the waits are over. Where frames and steps are equally long m is zero
from the first packet on.

At the device a packet always comes when the one before is played: m is zero.

Equations: docs/theory.md 15.3.
"""

import functools
import math
from typing import NamedTuple

from pmwvc_analysis.models.links import AMPLE_J, delay_ticks, serve_phase
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.margin import WINDOW_S
from pmwvc_core.wave.playout import Playout

BEGUN_S = 1.0  # from when on a session that was at rest has energy
SETTLED_S = 12.0 * WINDOW_S  # by then nothing of a margin is left
SPACING_S = 4e-3  # of the cases looked at
BEGINNINGS = 24  # at most, evenly over the hyperperiod
NARROW_S = 1e-5  # of a range: no range
SAME_S = 1e-10  # from one hyperperiod to the next: it stays


class AtHand(NamedTuple):
    """The least time at hand of a user's playout at the server [s].

    Attributes
    ----------
    begun_s
        Once the first waits of a session in virtual time are over, before anything is caught up.
    settled_s
        In the end.
    least_s, most_s
        Range of both over all beginnings and energies.
    settles
        Whether no playout waits again and again: else m changes for ever.
    """

    begun_s: float
    settled_s: float
    least_s: float
    most_s: float
    settles: bool

    @property
    def is_known(self) -> bool:
        """Tell whether it is the same from every beginning."""
        return self.settles and self.most_s - self.least_s < NARROW_S


def at_hand(user: User, scenario: Scenario, *, live: bool) -> AtHand:
    """Return the least time at hand of a user's playout at the server."""
    return _found(
        user.master.rate_drop,
        scenario.period_ticks,
        # Which steps meet the packets: a later arrival by whole steps is the same.
        delay_ticks(user.link_up, tick_s=scenario.tick_s, live=live) % scenario.period_ticks,
        serve_phase(scenario, live=live),
        scenario.tick_s,
    )


class Cases(NamedTuple):
    """The least times at hand for which stability is looked at, each for every user [s].

    Attributes
    ----------
    all
        That of a settled session, and, where there is a range, points of it.
    in_order
        How many of the latter follow each other along the range, all users together.
    settles
        Whether every playout settles.
    """

    all: list[list[float]]
    in_order: int
    settles: bool


def cases(scenario: Scenario, *, live: bool) -> Cases:
    """Return the cases to look at; one where nothing else is possible."""
    if not scenario.strict:
        return Cases([[]], 0, True)
    users = [at_hand(user, scenario, live=live) for user in scenario.users]
    settled = [user.settled_s for user in users]
    settles = all(user.settles for user in users)
    if not settles or all(user.is_known for user in users):
        return Cases([settled], 0, settles)
    least, most = [user.least_s for user in users], [user.most_s for user in users]
    parts = math.ceil(max(most) / SPACING_S)
    along = [
        [low + (high - low) * k / parts for low, high in zip(least, most, strict=True)]
        for k in range(parts + 1)
    ]
    apart = [[*least[:i], most[i], *least[i + 1 :]] for i in range(len(users)) if len(users) > 1]
    return Cases([settled, *along, *apart], len(along), True)


def words(scenario: Scenario, *, live: bool) -> str:
    """Return in sentences for which times at hand the model holds; empty where there is one."""
    if not scenario.strict:
        return ""
    users = [(user.name, at_hand(user, scenario, live=live)) for user in scenario.users]
    found = [
        f"{name} {own.settled_s * 1e3:.1f} ms in the end, 0 to {own.most_s * 1e3:.1f} ms possible"
        for name, own in users
        if not own.is_known
    ]
    if not found:
        return ""
    head = (
        "Frames and server steps are not equally long, so the time that the server's playouts "
        f"have at hand depends on how a session begins and catches up ({'; '.join(found)})."
    )
    if all(own.settles for _, own in users):
        return f"{head} The spectral radius is that of the end; a verdict holds for all of them."
    return (
        f"{head} It does not settle: the playouts wait again and again, the spectral radius is "
        "approximate, and whether the session is stable is not known."
    )


@functools.lru_cache(maxsize=4096)
def _found(frame: int, step: int, delay: int, phase: int, tick_s: float) -> AtHand:
    """Return the same by ticks: length of frame and step, delay up, and phase of the steps."""
    if frame == step:
        return AtHand(0.0, 0.0, 0.0, 0.0, True)
    ticks = math.lcm(frame, step)
    own = functools.partial(_Course, frame, step, delay, phase, tick_s=tick_s)
    frames = ticks // frame
    begun = [
        own(frame * first, energy_j=energy_j).settled(BEGUN_S)
        for first in range(0, frames, max(1, frames // BEGINNINGS))
        for energy_j in (0.0, AMPLE_J)
    ]
    session = own(0, energy_j=0.0)
    begun_s = session.settled(BEGUN_S)
    session.energy_j = AMPLE_J
    rounds = [session.least_s() for _ in range(math.ceil(SETTLED_S / (ticks * tick_s)))]
    later = rounds[-max(2, len(rounds) // 4) :]
    most_s = max([begun_s, *begun, *rounds])
    return AtHand(begun_s, rounds[-1], 0.0, most_s, max(later) - min(later) < NARROW_S)


class _Course:
    """One playout at rest, of a user whose first packet is sent at a tick: that one joins, those
    behind it are played.
    """

    def __init__(
        self,
        frame: int,
        step: int,
        delay: int,
        phase: int,
        sent: int,
        *,
        tick_s: float,
        energy_j: float,
    ) -> None:
        self.energy_j = energy_j
        self._frame, self._step, self._tick_s = frame, step, tick_s
        self._looks = math.lcm(frame, step) // step
        self._playout = Playout(most_repaid=1.0)
        joined = sent + delay
        self._look = joined + (phase - joined) % step  # the next one [ticks]
        self._due = joined + frame  # the next packet's arrival

    def least_s(self) -> float:
        """Go on by a hyperperiod; return the least time at hand behind a step [s]."""
        least_s, playout = math.inf, self._playout
        for _ in range(self._looks):
            while self._due <= self._look:
                playout.add(0.0, self.energy_j, self._frame * self._tick_s)
                self._due += self._frame
            playout.step(self._step * self._tick_s)
            least_s = min(least_s, float(playout.at_hand_s))
            self._look += self._step
        return least_s

    def settled(self, after_s: float) -> float:
        """Go on for so long, and until two hyperperiods have the same; return that [s]."""
        rounds, before_s = math.ceil(after_s / (self._looks * self._step * self._tick_s)), -1.0
        for number in range(4 * rounds + 8):
            least_s = self.least_s()
            if number >= rounds and abs(least_s - before_s) < SAME_S:
                break
            before_s = least_s
        return least_s
