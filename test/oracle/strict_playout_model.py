# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of a playout of the strict channel, written from theory.md section 17 (17.1 to
17.3, 17.14, 17.18, 17.19, 17.25, 17.27 to 17.30) and nothing else.

Everything is kept on the sender's own axis of time: a polygon U(s) of the integral that arrived,
and the moment ``played`` up to which it was given out. Signals are arrays of ``dof`` numbers.
"""

import bisect
import math

import numpy as np

MS = 1e-3


class Polygon:
    """The integral of a wave over the sender's time, and the least energy that each edge takes."""

    def __init__(self, dof):
        self.times, self.values, self.least_j = [0.0], [np.zeros(dof)], [0.0]

    @property
    def end(self):
        return self.times[-1]

    def extend(self, change, lasts_s, most_j):
        self.times.append(self.end + lasts_s)
        self.values.append(self.values[-1] + change)
        self.least_j.append(self.least_j[-1] + most_j)

    def _inside(self, moment, column):
        moment = min(max(moment, 0.0), self.end)
        right = min(max(bisect.bisect_left(self.times, moment), 1), len(self.times) - 1)
        span = self.times[right] - self.times[right - 1]
        part = (moment - self.times[right - 1]) / span
        return (1.0 - part) * column[right - 1] + part * column[right]

    def integral(self, moment):
        return self._inside(moment, self.values) if self.end else self.values[0]

    def takes_j(self, moment):
        """Energy that the smoothest wave from a moment to the end takes."""
        return self.least_j[-1] - self._inside(moment, self.least_j) if self.end else 0.0


class PlayedWave:
    """What one end plays out of a wave: 17.2, 17.3, 17.14, 17.18, 17.19, 17.25, 17.29."""

    def __init__(self, dof, *, lent_once_j, fastest_repaid, grows_s, steps=1):
        self.dof, self.e0_j, self.steps, self.raised = dof, lent_once_j, steps, 1.0
        self.fastest_repaid, self.grows_s = fastest_repaid, grows_s
        self.keeps_j = 2.5 * MS - lent_once_j
        self.came_j = self.out_j = self.passed_j = self.dropped_j = 0.0
        self.begin()

    def begin(self):
        rest = self.came_j - self.out_j - self.passed_j - self.dropped_j
        self.dropped_j += max(rest, 0.0)
        self.line, self.played = Polygon(self.dof), 0.0
        self.newest_wave = np.zeros(self.dof)
        self.owed = np.zeros(self.dof)  # undelivered
        self.guess, self.wrong = np.zeros(self.dof), np.zeros(self.dof)
        self.anything_owed, self.given_part = False, 1.0
        self.ramp = [(np.zeros(self.dof), 0.0)] * self.steps  # asked in the last steps
        self.quiet_s = self.shift_s = self.calm_s = 0.0
        self.speed, self.settling_s, self.packet_s = 1.0, 100 * MS, 0.0
        self.already_came = False

    # -- energy -------------------------------------------------------------------------------
    @property
    def free_j(self):
        held = self.came_j - self.out_j - self.passed_j - self.dropped_j
        # of what was asked so many steps ago, so many parts are still to come
        still = sum(age * j / self.steps for age, (_, j) in enumerate(self.ramp))
        return held - self.line.takes_j(self.played) - still

    @property
    def wants_j(self):
        wants_j = self.keeps_j  # 17.25: the hand fills it up to 2.5 mJ
        if self.owed @ self.owed > 5e-4**2:
            newest = math.sqrt(self.newest_wave @ self.newest_wave)
            wants_j = (
                max(wants_j, 0.0)
                + 0.1 * MS
                + self.raised * math.sqrt(self.owed @ self.owed) * newest
            )
        return wants_j

    @property
    def lacks(self):
        return bool(self.free_j < self.wants_j)

    def hand_out(self, most_j, *, keeps_j=0.0):
        given = max(min(self.free_j - keeps_j, most_j), 0.0)
        self.passed_j += given
        return given

    def surplus(self, lasts_s, *, asked_for, of_e0=False):
        if not asked_for:
            return 0.0
        most_j = max(self.free_j - self.wants_j, 0.0) * min(lasts_s / 0.1, 1.0)
        return self.hand_out(most_j, keeps_j=min(self.keeps_j, 0.0) if of_e0 else 0.0)

    # -- arrivals -----------------------------------------------------------------------------
    @property
    def tells_the_other(self):
        return self.quiet_s > 60 * MS

    @property
    def brakes(self):
        return self.quiet_s > 100 * MS

    def arrive(self, change, paid_j, lasts_s):
        self.came_j += paid_j
        ahead_s = self.played - self.line.end  # > 0: that much was concealed
        outage = self.brakes
        if outage:
            self.settling_s = 100 * MS
        else:
            self.packet_s = lasts_s
        if not self.already_came and self.settling_s <= 0.0:
            self.shift_s -= ahead_s * min(lasts_s / 0.4, 1.0)
        self.already_came = True
        concealed = self.line.end > 0.0 and ahead_s > 0.0
        least_j = float(change @ change) / (2.0 * lasts_s)
        covered_j = paid_j + max(self.free_j - paid_j, 0.0)
        if least_j > covered_j + self.e0_j * lasts_s / (30 * MS):  # 17.30
            paid = change * math.sqrt(paid_j / least_j)
            self._owe(change - paid)
            change, least_j = paid, paid_j
        self.line.extend(change, lasts_s, min(self.raised * least_j, paid_j))
        self.newest_wave, self.quiet_s = change / lasts_s, 0.0
        if not concealed:
            return
        overlap_s = min(ahead_s, lasts_s)
        guessed = self.guess * (overlap_s / ahead_s)
        self.wrong = self.wrong + change * (overlap_s / lasts_s) - guessed
        self.guess = self.guess - guessed
        if outage:
            self._owe(self.wrong)
            self.wrong = np.zeros(self.dof)

    def _owe(self, integral):
        self.owed, self.anything_owed = self.owed + integral, True

    def stand_still(self, lasted_s):
        """Time in which the loop did not run: what was due then is undelivered."""
        if not self.line.end:
            return
        before = self.line.integral(self.played)
        self.played += max(min(lasted_s, self.line.end - self.played), 0.0)
        if lasted_s > 100 * MS:
            self.settling_s = 100 * MS
        self._owe(self.line.integral(self.played) - before)

    # -- time ---------------------------------------------------------------------------------
    def _clock(self, h):
        """Advance ``played`` by 17.18; return from where on, and the time beyond what has come."""
        longest_s = self.packet_s if self.settling_s > 0.0 else 0.3
        self.settling_s = max(self.settling_s - h, 0.0)
        too_early_s = self.line.end - self.played - h - longest_s
        if too_early_s > 0.0:
            before = self.line.integral(self.played)
            self.played += too_early_s
            self._owe(self.line.integral(self.played) - before)
        begun = self.played
        left_s = 120 * MS - (begun - self.line.end)
        self.speed = max(min(left_s / (40 * MS), 1.0, self.speed + h / (30 * MS)), 0.0)
        haste = min(max(self.shift_s / (50 * MS), -0.3), 0.3)
        self.shift_s -= haste * self.speed * h
        self.played = begun + min((1.0 + haste) * self.speed * h, left_s)
        if abs(self.played - self.line.end) < 1e-12:
            self.played = self.line.end
        self.already_came = False
        if self.played <= self.line.end:
            return begun, 0.0
        self.quiet_s += max(h - max(self.line.end - begun, 0.0), 0.0)
        return begun, self.played - max(begun, self.line.end)

    def play(self, h):
        """The wave of the next ``h`` seconds."""
        if not self.line.end:
            return np.zeros(self.dof)
        on_loan_j = min(max(-self.free_j, 0.0), self.e0_j)
        begun, beyond_s = self._clock(h)
        predicted = self.newest_wave * beyond_s
        mended = self.wrong * min(h / (30 * MS), 1.0)
        due = self.line.integral(self.played) - self.line.integral(begun) + predicted + mended
        least_j = self.line.takes_j(begun) - self.line.takes_j(self.played)
        self.ramp = [*self.ramp[1:], (due, least_j)]
        due = sum(each for each, _ in self.ramp) / self.steps
        paid_j = sum(j for _, j in self.ramp) / self.steps
        self.guess, self.wrong = self.guess + predicted, self.wrong - mended
        if beyond_s > 0.0 or self.raised * float(due @ due) / (2.0 * h) > paid_j:
            on_loan_j = self.e0_j
        free_j = self.free_j
        # 17.2 and 17.29
        energy_j = max(free_j + on_loan_j, 0.0)
        wave = self.given_part * due / h
        needs_w = 0.5 * self.raised * float(wave @ wave)
        if beyond_s <= 0.0:
            self.given_part = min(self.given_part + h / (30 * MS), 1.0)
        elif needs_w > energy_j / max(h, 30 * MS):
            self.given_part *= 1.0 - 0.5 * needs_w * h / max(energy_j, needs_w * h)
        self.calm_s = 0.0 if self.brakes or self.given_part < 1.0 else self.calm_s + h
        wave = self.given_part * due / h
        needs_w = 0.5 * self.raised * float(wave @ wave)
        if needs_w * h > energy_j:
            wave = wave * math.sqrt(energy_j / (needs_w * h))
        if self.given_part < 1.0 or needs_w * h > energy_j:
            self._owe(due - wave * h)
        if self.anything_owed and self.calm_s > 0.1:
            wave = wave + self._made_up(
                wave, max(free_j - min(self.keeps_j, 0.0), 0.0) / self.raised, h
            )
        spent_j = 0.5 * h * self.raised * float(wave @ wave)
        self.out_j += spent_j
        if free_j > 0.05 and self.owed @ self.owed <= 5e-4**2:
            self.dropped_j += max(self.free_j - 0.05, 0.0)
        return wave

    def _made_up(self, wave, energy_j, h):
        """17.14: w = 2 (E/|D| - v) along D, as far as the energy of this step lasts."""
        size = math.sqrt(self.owed @ self.owed)
        if size == 0.0:
            return np.zeros(self.dof)
        towards = self.owed / size
        wish = min(2.0 * (energy_j / size - wave @ towards), size / 0.1)
        wish = max(wish, size / 0.7)
        wish = min(wish, self.fastest_repaid * min((self.calm_s - 0.1) / self.grows_s, 1.0))
        wish *= max(3.0 * self.speed - 2.0, 0.0)
        # the longest s with |wave + s towards|^2 h/2 <= energy
        room = 2.0 * energy_j / h - wave @ wave
        along = wave @ towards
        if wish * (wish + 2.0 * along) > room:
            wish = min(max(math.sqrt(along * along + max(room, 0.0)) - along, 0.0), wish)
        risen = max(wish / self.fastest_repaid, 0.1)
        self.calm_s = min(self.calm_s, 0.1 + self.grows_s * risen)
        self.owed = self.owed - wish * h * towards
        self.anything_owed = bool(np.any(np.abs(self.owed) > 1e-15))
        return wish * towards
