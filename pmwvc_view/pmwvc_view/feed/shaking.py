# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The detector of a device that shakes, or whose force stays at its limit, while a session runs.

The criterion is the report's (:mod:`pmwvc_analysis.verdicts.oscillation`) on the newest
``SPAN_S``: velocity beyond the band of purposeful motion, for most of the last two seconds, that
does not die out. It needs about a second of shaking. Slower oscillation is not found, nor that of
the object alone.

A person with a pointer moves up to 10 Hz. Once no target of a hand has moved for ``STILL_S``, what
is faster than ``STILL_HZ`` and the simulated hands is no purpose either.

The band is that of the scenario's hands; where they close, that of closing, at any time. Contact
that is made or lost begins the judgement anew, unless it comes and goes faster than on purpose.
Where more than 1 % of the span went by in waiting for late packets, a motion counts only if the
loop is seen to keep it up (:mod:`pmwvc_analysis.verdicts.kept_up`): the network moves devices as
well.

Waiting is judged as in the report (:mod:`pmwvc_analysis.traces.arrivals`), from when packets left
their links: more than half a frame late counts.
"""

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.traces import bands
from pmwvc_analysis.traces.arrivals import LATE, UNEVEN
from pmwvc_analysis.traces.holes import without
from pmwvc_analysis.verdicts import oscillation
from pmwvc_analysis.verdicts.kept_up import kept_up, power_of
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.feed.traces import NS

KEPT = 500  # waits of a link


class Waits:
    """The waits of all links, up and down for each user; none where frames are not known."""

    def __init__(self, scenario: Scenario | None, users: Sequence[str]) -> None:
        known = {user.name: user for user in scenario.users} if scenario else {}
        self._due_ns: list[float] = []
        for name in users:
            up_s = known[name].master.frame_s if name in known else np.inf
            down_s = scenario.server.period_s if scenario else np.inf
            self._due_ns += [up_s * NS, down_s * NS]
        self._newest_ns = [-1] * len(self._due_ns)
        self._waits = [deque[tuple[float, float]](maxlen=KEPT) for _ in self._due_ns]

    def packets(self, link: int, out_ns: Array) -> None:
        """Take in when packets left a link [ns] (0: never)."""
        times = np.sort(out_ns[out_ns > 0]).astype(np.int64).tolist()
        before = self._newest_ns[link]
        for time_ns in times:
            if before >= 0 and time_ns - before > (1.0 + LATE) * self._due_ns[link]:
                self._waits[link].append((before / NS, time_ns / NS))
            before = max(before, time_ns)
        self._newest_ns[link] = before

    def ratio(self, begin_s: float, end_s: float) -> float:
        """Return the largest ratio, over the links, of a time that went by in waiting."""
        waited = [
            sum(max(min(end, end_s) - max(begin, begin_s), 0.0) for begin, end in waits)
            for waits in self._waits
        ]
        return max(waited, default=0.0) / (end_s - begin_s)

    def timely(self, begin_s: float, end_s: float) -> list[tuple[float, float]]:
        """Return the stretches of a time, from and until [s], in which nothing waited."""
        return without(itertools.chain.from_iterable(self._waits), begin_s, end_s)


SPAN_S = 3.0
JUDGED_NS = NS // 2  # between two judgements
STILL_S = 1.5  # without a move on purpose: what moves then is no hand
STILL_HZ = 2.0  # least band of what moves then: cubes that coast, hands that come to rest
LATE_S = 1.0  # newest part, of which the amount is told


class Shake(NamedTuple):
    """A device that shakes: half the swing of its force in the newest second [N], and the
    frequency at which its velocity is strongest [Hz].
    """

    force_n: float
    frequency_hz: float

    def __str__(self) -> str:
        """Return amount and frequency in words."""
        return f"+-{self.force_n:.2g} N at {self.frequency_hz:.0f} Hz"


class Shaking:
    """Whether a user's device shakes, judged twice a second.

    The scenario gives bands, noise and limits; None: as the report where it has none. ``waits``
    are those of all links.

    Attributes
    ----------
    contacts, moved_ns
        When contact was made or lost, and when somebody took, moved or let go of a hand last
        [ns]; whoever learns of it notes it here.
    shake
        Amount and frequency as of now; None where it does not shake.
    limit_n
        The force's limit [N] where it was there for most of the newest second; else None.
    shook
        The latest shaking that is over, and when it was seen last [ns]; None: there was none.
    """

    def __init__(self, scenario: Scenario | None, name: str, waits: Waits) -> None:
        self._waits = waits
        users = {user.name: user for user in scenario.users} if scenario else {}
        user = users.get(name)
        self._band_hz, self._images = bands.DEFAULT_BAND_HZ, 0.0
        self._still = self._band_hz, self._images
        self.moved_ns = 0
        if scenario is not None:
            closing = scenario.task.closes and any(
                each.operator.is_hand for each in users.values()
            )
            self._band_hz, self._images = bands.bands(scenario, closing=closing)
            self._still = still_bands(scenario, (self._band_hz, self._images))
        self._noise_m_s = bands.encoder_noise_m_s(user)
        self._most_n = user.safety.max_force if user is not None else np.inf
        # The newest SPAN_S: times [s], velocities [m/s] and forces applied [N] of ticks, put
        # together only where they are judged.
        self._ticks: list[tuple[Array, Array, Array]] = []
        self.contacts: deque[int] = deque()
        self._due_ns = 0
        self._seen: tuple[Shake, int] | None = None  # strongest of the present one, and the latest
        self.shake: Shake | None = None
        self.limit_n: float | None = None
        self.shook: tuple[Shake, int] | None = None

    def block(self, start_ns: int, period_ns: int, velocity: Array, force: Array) -> None:
        """Take in consecutive ticks; judge where that is due."""
        times = (start_ns + period_ns * np.arange(len(velocity))) / NS
        self._ticks.append((times, velocity, force))
        end_ns = start_ns + period_ns * (len(velocity) - 1)
        if end_ns < self._due_ns:
            return
        self._due_ns = end_ns + JUDGED_NS
        begin_s = end_ns / NS - SPAN_S
        while self.contacts and self.contacts[0] <= begin_s * NS:
            self.contacts.popleft()
        times, velocity, force = map(np.concatenate, zip(*self._ticks, strict=True))
        first = int(np.searchsorted(times, begin_s, side="right"))
        self._ticks = [(times[first:], velocity[first:], force[first:])]
        self._judge(*self._ticks[0], end_ns, period_ns / NS)

    def _judge(
        self, times: Array, velocity: Array, force: Array, end_ns: int, period_s: float
    ) -> None:
        late = times > times[-1] - LATE_S
        size = np.linalg.norm(force[late], axis=-1)
        at_limit = np.mean(size >= 0.999 * self._most_n) > 0.5
        self.limit_n = self._most_n if at_limit else None
        # The span is the second half of a time line that begins at zero, as the report judges it.
        zero_s = end_ns / NS - 2.0 * SPAN_S
        moved_s = self.moved_ns / NS - zero_s
        still = 2.0 * SPAN_S - moved_s >= STILL_S
        band_hz, images = self._still if still else (self._band_hz, self._images)
        disturbed_s = 0.0  # when contact was made or lost last
        if 0 < len(self.contacts) <= max(oscillation.CHATTER, band_hz * SPAN_S):
            disturbed_s = self.contacts[-1] / NS - zero_s  # no more often than a motion within it
        motion = oscillation.Motion(
            "device",
            times - zero_s,
            period_s,
            velocity,
            band_hz,
            self._noise_m_s,
            images,
            max(disturbed_s, moved_s if still else 0.0),
        )
        found = oscillation.strength(motion, 2.0 * SPAN_S)
        shakes = oscillation.lasts(found, motion) and found.settled
        begin_s, end_s = zero_s + SPAN_S, zero_s + 2.0 * SPAN_S
        if shakes and self._waits.ratio(begin_s, end_s) > UNEVEN:
            timely = [
                (from_s - zero_s, until_s - zero_s)
                for from_s, until_s in self._waits.timely(begin_s, end_s)
            ]
            shakes = kept_up(found, motion, 2.0 * SPAN_S, timely)
        if shakes:
            self.shake = self._amount(velocity[late], force, period_s, band_hz)
            strongest = self._seen[0] if self._seen else self.shake
            self._seen = max(strongest, self.shake), end_ns
        else:
            self.shook, self._seen = self._seen or self.shook, None
            self.shake = None

    def _amount(self, velocity: Array, force: Array, period_s: float, band_hz: float) -> Shake:
        rows = len(velocity)
        whole = force[-rows:]
        part = oscillation.beyond(force, period_s, band_hz)[-rows:]
        swing = np.minimum(np.ptp(whole, axis=0), np.ptp(part, axis=0))
        fast = oscillation.beyond(velocity, period_s, band_hz)
        strongest = int(np.argmax(power_of(fast)))
        return Shake(float(swing.max()) / 2.0, float(np.fft.rfftfreq(rows, period_s)[strongest]))


def still_bands(scenario: Scenario, moving: tuple[float, float]) -> tuple[float, float]:
    """Return band [Hz] and ratio of images while every hand that is moved from outside rests;
    those of moving hands where that is not told.
    """
    remote = [user for user in scenario.users if user.operator.is_remote]
    if not remote or any(user.operator.file for user in remote):
        return moving
    resting = tuple(
        replace(user, operator=replace(user.operator, kind="none")) if user in remote else user
        for user in scenario.users
    )
    band_hz, images = bands.bands(replace(scenario, users=resting), closing=False)
    return (max(band_hz, STILL_HZ), images) if band_hz < moving[0] else moving
