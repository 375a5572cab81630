# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A sender with its lives, a network, somebody who plays back, and a receiver that answers: what
may be given out is reckoned here from the packets that were really made and have come.
"""

import dataclasses
import heapq
from random import Random

import numpy as np

from pmwvc_core.ends.inbox import Inbox
from pmwvc_core.transport.packet import FLAG_CHALLENGE, FLAG_LEAVING, LAST_NUMBER, Receipt
from support.packer import Packer
from support.receiving import ReceivingEnd

PERIOD_S, STEP_S, RELEASE_S = 0.008, 0.004, 1.0
PERIOD_NS = 8_000_000
WILD_STEPS, CALM_STEPS = 500, 750  # the second longer than the longest delay
COUNTED = (Receipt.ACCEPTED, Receipt.NEW_EPOCH)


class Believing(Inbox):
    """The control: eight packets in a row are believed, once nothing else came for a while."""

    row = (0, 0, 0)  # epoch, number, how many

    def _placed(self, packet, now_ns):
        verdict = super()._placed(packet, now_ns)
        if verdict in COUNTED:
            return verdict
        epoch, seq, count = self.row
        count = count + 1 if packet.epoch == epoch and packet.seq > seq else 1
        self.row = packet.epoch, packet.seq, count
        return Receipt.NEW_EPOCH if count >= 8 and self.silent(now_ns) else verdict


def strict(inbox=Inbox):
    return ReceivingEnd("strict", period_s=PERIOD_S, timeout_s=0.03, inbox=inbox)


def plain():
    return ReceivingEnd("plain", period_s=PERIOD_S, timeout_s=0.03)


class World:
    """A sender with its lives, a network and somebody who plays back, a receiver that answers."""

    def __init__(self, seed, end, *, forges=False):
        self.draw, self.end, self.forges = Random(seed), end, forges
        self.inbox = end.inbox
        self.now_ns = self.step = self.epoch = 0
        self.answers = Packer(1000, period=PERIOD_S)
        self.under_way = []  # (time, order, whether up, packet)
        self.made, self.index = [], {}  # true packets, and their places by identity
        self.paid_j, self.moved = 0.0, 0.0  # of this life
        self.came_j, self.came = {}, {}  # of those that have come, by epoch: the largest sums
        self.given_j = self.out = 0.0
        self.least_j = self.least = np.inf
        self.in_order, self.newest = True, -1
        self.there = False
        self.begin_life()

    def begin_life(self):
        self.epoch += 1
        self.packer = Packer(self.epoch, period=PERIOD_S)
        self.packer.seq = self.draw.choice((0, 0, LAST_NUMBER - self.draw.randrange(200)))
        self.ears = plain().inbox
        self.paid_j = self.moved = 0.0
        self.away = 0  # steps without a sender

    def run(self):
        self.calm = False
        while self.step < WILD_STEPS:
            if self.step % 25 == 0:
                self.change_weather()
            self.one_step()
        self.calm, self.delay_s, self.loss = True, 0.016, 0.0
        self.away = min(self.away, 1)
        while self.step < WILD_STEPS + CALM_STEPS:
            self.one_step()
        return self

    def change_weather(self):
        draw = self.draw
        self.delay_s = draw.choice((0.0, 0.016, 0.1, 0.4, 2.2, 5.0))
        self.loss = draw.choice((0.0, 0.0, 0.1, 1.0))
        event = draw.choice(("", "", "restart", "leave", "stall", "play back", "play back"))
        if event == "restart":
            self.begin_life()
        elif event in ("leave", "stall") and not self.away:
            self.away = draw.randrange(5, 200)
            if event == "leave":
                self.send(FLAG_LEAVING)
                self.away_for_good = True
        elif event == "play back" and self.made:
            first = draw.randrange(len(self.made))
            old = self.made[first : first + draw.choice((12, 40))]
            for n, packet in enumerate(old):
                self.put(self.now_ns + n * PERIOD_NS, True, packet)

    away_for_good = False

    def one_step(self):
        self.step += 1
        self.now_ns = self.step * PERIOD_NS
        if self.away:
            self.away -= 1
            if not self.away and self.away_for_good:
                self.away_for_good = False
                self.begin_life()
        else:
            self.send()
        self.deliver()
        for _ in range(2):
            self.play()
        since_s = (self.now_ns - self.inbox.accepted_ns) * 1e-9
        if self.inbox.newest is None or since_s > RELEASE_S:
            self.there = False
        if self.there or self.inbox.challenges(self.now_ns):
            flags = 0 if self.there else FLAG_CHALLENGE
            echo = self.inbox.echo(self.now_ns)
            self.travel(False, self.answers.pack(0.0, 0.0, self.now_ns, flags, echo))

    def send(self, flags=0):
        wave = self.draw.random()
        self.moved += wave * PERIOD_S
        self.paid_j += self.draw.choice((0.0, 0.5, 1.0, 1.0)) * 0.5 * wave**2 * PERIOD_S
        echo = self.ears.echo(self.now_ns)
        packet = self.packer.pack(wave, 0.0, self.now_ns, flags, echo, self.paid_j)
        self.index[id(packet)] = len(self.made)
        self.made.append(packet)
        self.travel(True, packet)
        if self.forges and not self.calm and self.draw.random() < 0.02:
            share = self.draw.random()
            self.travel(True, dataclasses.replace(
                packet,
                seq=min(packet.seq + self.draw.choice((1, 1000, 1 << 31)), LAST_NUMBER),
                sent_ns=self.draw.choice((packet.sent_ns, 1 << 60)),
                energy=packet.energy * share,
                integral=packet.integral * share,
            ))  # fmt: skip

    def travel(self, up, packet):
        for _ in range(1 if self.calm else self.draw.choice((1, 1, 1, 2))):
            if self.draw.random() >= self.loss:
                late_s = self.delay_s * (1.0 if self.calm else self.draw.uniform(0.5, 1.0))
                self.put(self.now_ns + round(late_s * 1e9), up, packet)

    def put(self, at_ns, up, packet):
        heapq.heappush(
            self.under_way, (at_ns, len(self.under_way) + self.step * 10**6, up, packet)
        )

    def deliver(self):
        while self.under_way and self.under_way[0][0] <= self.now_ns:
            *_, up, packet = heapq.heappop(self.under_way)
            if not up:
                self.ears.take([packet], self.now_ns)
                continue
            true, epoch = self.index.get(id(packet)), packet.epoch
            # a forged one has a share of what its true sender had paid by then
            self.came_j[epoch] = max(self.came_j.get(epoch, 0.0), packet.energy)
            if true is not None:
                self.came[epoch] = max(self.came.get(epoch, 0.0), packet.integral)
            taken = self.end.push(packet, self.now_ns)
            if taken is None:
                continue
            if true is not None:
                self.in_order &= true > self.newest
                self.newest = true
            if taken.fresh or not self.there:
                # what was guessed of one who was gone is not made good: it joins where it is now
                self.out += min(self.end.waiting, 0.0) if self.end.p.plays_on else 0.0
                self.end.anew()
            self.there = not taken.leaves

    def play(self):
        wave = self.end.step(STEP_S)
        if self.end.p.plays_on:
            self.given_j += 0.5 * wave * wave * STEP_S
            self.out += wave * STEP_S
            least = sum(self.came.values()) - self.out - self.end.waiting
            self.least_j = min(self.least_j, sum(self.came_j.values()) - self.given_j)
            self.least = min(self.least, least)
