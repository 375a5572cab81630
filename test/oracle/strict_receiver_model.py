# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of what an end of the strict channel counts of packets, and of the friction with
which it brakes, written from theory.md section 17 (17.15, 17.24).
"""

import math

import numpy as np


class Receiver:
    """What is counted of a sender's packets: 17.24, the time of silence, and whether it hears us.

    A packet is anything with the fields of a packet; times are integer nanoseconds.
    """

    def __init__(self, dof, played, *, period_s, timeout_s, longest_wave):
        self.dof, self.played = dof, played
        self.period_s, self.timeout_s, self.longest = period_s, timeout_s, longest_wave
        self.sums = None  # integral and energy counted
        self.last = None
        self.at_ns = 0
        self.silence_ns = round(max(timeout_s, 3.0 * period_s) * 1e9)
        self.interval_s, self.late_s = period_s, 0.0
        self.shortest_s = self.longest_s = period_s
        self.unheard_since = self.stranger_ns = None
        self.seen = set()

    def take(self, packet, now_ns):
        """Count a packet; tell whether it counts, and whether its sender begins with it."""
        integral, energy = np.array(packet.integral, float).reshape(-1), float(packet.energy)
        wave = np.array(packet.wave, float).reshape(-1)
        if not np.all(np.isfinite([*integral, *wave, energy])) or not packet.period > 0.0:
            return False, False
        if math.sqrt(wave @ wave) > self.longest:
            return False, False
        began = self.last is None
        if not began:
            again = packet.seq in self.seen
            proven, left = self.at_ns < packet.echo_sent_ns <= now_ns, self.last.flags & 2
            if packet.epoch != self.last.epoch:
                if not (proven and (left or self.silent(now_ns))):
                    self.stranger_ns = now_ns
                    return False, False
                began = True
            elif (left or packet.seq <= self.last.seq) and not proven:
                if left and not again:
                    self.stranger_ns = now_ns
                self.seen.add(packet.seq)
                return False, False
        if not packet.flags & 16:
            self.unheard_since = None
        elif self.unheard_since is None:
            self.unheard_since = now_ns
        last, self.last, self.stranger_ns = self.last, packet, None
        self.seen = {packet.seq} if began else self.seen | {packet.seq}
        passed_s, self.at_ns = (now_ns - self.at_ns) * 1e-9, now_ns
        if began:
            self.sums = [integral, energy]
            self._anew(wave, 0.0, packet.period)
            return True, True
        lasts_s = min(self._lasts(last, packet), passed_s + 10.0)
        change = integral - self.sums[0]
        reach = self.longest * lasts_s
        if change @ change > reach * reach:
            change = change * (reach / math.sqrt(change @ change))
        paid_j = min(max(energy - self.sums[1], 0.0), 0.5 * self.longest**2 * lasts_s)
        self.sums = [self.sums[0] + change, self.sums[1] + paid_j]
        if (packet.flags ^ last.flags) & 8:
            self._anew(wave, paid_j, packet.period)
            return True, False
        self.played.arrive(change, paid_j, lasts_s)
        self.late_s += (abs(passed_s - lasts_s) - self.late_s) / 16.0
        self.interval_s += (packet.period - self.interval_s) / 16.0
        self.interval_s = max(self.interval_s, packet.period)
        usual_s = 3.0 * self.interval_s + 4.0 * self.late_s
        self.silence_ns = round(max(self.timeout_s, usual_s) * 1e9)
        return True, False

    def _anew(self, wave, paid_j, lasts_s):
        self.played.begin()
        own_j = 0.5 * lasts_s * float(wave @ wave)
        self.played.arrive(wave * lasts_s, min(own_j, paid_j), lasts_s)
        self.shortest_s = self.longest_s = lasts_s

    def _lasts(self, last, packet):
        self.shortest_s = min(self.shortest_s, packet.period)
        self.longest_s = max(self.longest_s, packet.period)
        lost = packet.seq - last.seq - 1
        if lost <= 0:
            return packet.period
        by_clock_s = (packet.sent_ns - last.sent_ns) * 1e-9 - packet.period
        missing_s = min(max(by_clock_s, lost * self.shortest_s), lost * self.longest_s)
        return packet.period + missing_s

    def silent(self, now_ns):
        return self.last is None or now_ns - self.at_ns > self.silence_ns

    def unheard(self, now_ns):
        since = self.unheard_since
        return since is not None and self.at_ns - since > self.silence_ns

    def interrupted(self, now_ns):
        return self.unheard(now_ns) or self.played.brakes


class Friction:
    """17.15: the largest force of a brake, 1.3 times the mean force of the last 50 ms."""

    def __init__(self, step_s, lets_go_s):
        self.step_s, self.lets_go_s = step_s, lets_go_s
        self.release()

    def release(self):
        self.mean, self.held, self.part, self.acts = 0.0, 0.0, 0.0, False

    @property
    def limit(self):
        return self.held * self.part if self.acts else 0.0

    def step(self, waits, force):
        if not self.acts:
            self.mean = self.mean + min(self.step_s / 0.05, 1.0) * (force - self.mean)
            if not waits:
                return
            self.held, self.part = 1.3 * math.sqrt(self.mean @ self.mean), 0.0
        change = self.step_s / 0.04 if waits else -self.step_s / self.lets_go_s
        self.part = min(max(self.part + change, 0.0), 1.0)
        self.acts = self.part > 0.0
