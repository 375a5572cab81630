# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The choice of a receiver among several senders."""

import dataclasses
import random

from support.packer import Packer

from pmwvc_core.transport.packet import FLAG_CHALLENGE, FLAG_LEAVING, Receipt
from pmwvc_core.transport.receiver import REMEMBERED, Receiver

PERIOD_NS = 8_000_000
ROUND_TRIP_NS = 5 * PERIOD_NS
STRAY_NS = 25_000_000
SECOND_NS = 10**9


class Sender:
    """A sender whose wave is its epoch, and which answers what comes a round trip before."""

    def __init__(
        self, epoch, *, every_ns=PERIOD_NS, begin_ns=0, end_ns=10 * SECOND_NS, hears=True
    ):
        self.packer = Packer(epoch, period=0.008)
        self.begin_ns, self.hears = begin_ns, hears
        self.times = range(begin_ns, end_ns, every_ns)

    def packets(self):
        for now_ns in self.times:
            yield now_ns, self.packet(now_ns)

    def packet(self, now_ns, flags=0):
        heard_ns = now_ns - ROUND_TRIP_NS
        echo = (1, heard_ns, 0) if self.hears and heard_ns >= self.begin_ns else (0, 0, 0)
        return self.packer.pack(float(self.packer.epoch), 0.0, now_ns, flags, echo)


def receiver():
    return Receiver(1, period_s=0.008, timeout_s=0.03)


def followed(inbox, *senders):
    """Push the packets of all senders in the order of time; return (time, epoch) followed."""
    everything = sorted(
        (item for sender in senders for item in sender.packets()), key=lambda item: item[0]
    )
    found = []
    for now_ns, packet in everything:
        inbox.push(packet, now_ns)
        found.append((now_ns, inbox.epoch))
    return found


def test_a_second_sender_at_full_rate_never_takes_over_while_the_first_one_sends():
    inbox = receiver()
    found = followed(inbox, Sender(1), Sender(2, begin_ns=1000))
    assert {epoch for _, epoch in found} == {1}
    assert inbox.counts[Receipt.STRANGER] == inbox.strangers[2] == 1250


def test_another_sender_takes_over_after_the_silence_of_the_first_one():
    end = SECOND_NS
    found = followed(receiver(), Sender(1, end_ns=end), Sender(2, begin_ns=SECOND_NS // 2))
    taken = next(now for now, epoch in found if epoch == 2)
    assert end + 22_000_000 < taken <= end + 40_000_000  # silent 30 ms after its last packet
    assert {epoch for now, epoch in found if now > taken} == {2}


def test_a_sender_that_hears_nothing_never_takes_over():
    """The control of the one above; as of packets that are played back."""
    deaf = Sender(2, begin_ns=SECOND_NS // 2, hears=False)
    found = followed(receiver(), Sender(1, end_ns=SECOND_NS), deaf)
    assert {epoch for _, epoch in found} == {1}


def test_a_stray_that_was_there_first_gives_way_to_a_sender_that_hears():
    stray = Sender(2, every_ns=4 * STRAY_NS, hears=False)
    found = followed(receiver(), stray, Sender(1, begin_ns=300_000_001))
    taken = next(now for now, epoch in found if epoch == 1)
    assert taken < 400_000_000
    assert {epoch for now, epoch in found if now > taken} == {1}


def test_a_stray_that_comes_during_an_outage_does_not_take_over():
    inbox = receiver()
    before, stray = Sender(1, end_ns=SECOND_NS), Sender(2, hears=False)
    followed(inbox, before)
    for now_ns, packet in stray.packets():
        if SECOND_NS < now_ns < 2 * SECOND_NS:
            assert inbox.push(packet, now_ns) is Receipt.STRANGER
    back = before.packer.pack(1.0, 0.0, 2 * SECOND_NS)
    assert inbox.push(back, 2 * SECOND_NS) is Receipt.ACCEPTED


def test_a_flood_of_random_epochs_is_refused_counted_and_bounded():
    inbox = receiver()
    draw = random.Random(7)
    packer = Packer(1, period=0.008)
    for n in range(100):
        now_ns = n * PERIOD_NS
        good = packer.pack(1.0, 0.0, now_ns)
        assert inbox.push(good, now_ns) in (Receipt.ACCEPTED, Receipt.NEW_EPOCH)
        for _ in range(50):
            wild = dataclasses.replace(good, epoch=draw.getrandbits(64), wave=5.0)
            assert inbox.push(wild, now_ns + 1) is Receipt.STRANGER
        assert inbox.newest.wave == 1.0
    assert inbox.counts[Receipt.STRANGER] == 5000
    assert len(inbox.strangers) == REMEMBERED


def test_a_sender_that_comes_back_among_random_epochs_is_followed():
    inbox = receiver()
    followed(inbox, Sender(1, end_ns=SECOND_NS))
    draw = random.Random(7)
    again = Sender(3, begin_ns=2 * SECOND_NS, end_ns=2 * SECOND_NS + 7 * PERIOD_NS)
    for now_ns, new in again.packets():
        for _ in range(5):
            inbox.push(
                dataclasses.replace(new, epoch=draw.getrandbits(64), echo_sent_ns=0), now_ns
            )
        inbox.push(new, now_ns)
    assert inbox.epoch == 3


def test_after_a_goodbye_the_next_sender_begins_as_soon_as_it_was_challenged():
    inbox = receiver()
    old, new = Sender(1), Sender(2)
    for n in range(5):
        inbox.push(old.packet(n), n)
    inbox.push(old.packet(5, FLAG_LEAVING), 5)
    assert not inbox.challenges(6)
    assert inbox.push(new.packer.pack(2.0, 0.0, 6), 6) is Receipt.STRANGER
    assert inbox.challenges(7)
    answer = new.packer.pack(2.0, 0.0, 8, echo=(1, 7, 0))
    assert inbox.push(answer, 9) is Receipt.NEW_EPOCH
    assert not inbox.challenges(10)


def test_both_ends_that_were_started_again_find_each_other():
    """Lives that followed former ones: one goes on sending, the other one only answers."""
    here, there = receiver(), receiver()
    for inbox in (here, there):
        inbox.push(Packer(1, period=0.008).pack(0.0, 0.0, 0), 0)
    goes_on, answers = Packer(2, period=0.008), Packer(3, period=0.008)
    for now_ns in range(SECOND_NS, SECOND_NS + 20 * PERIOD_NS, PERIOD_NS):
        there.push(goes_on.pack(0.0, 0.0, now_ns, echo=here.echo(now_ns)), now_ns + 1)
        later_ns = now_ns + 2
        flags = 0 if there.epoch == 2 else FLAG_CHALLENGE * there.challenges(later_ns)
        if there.epoch == 2 or flags:
            echo = there.echo(later_ns)
            here.push(answers.pack(0.0, 0.0, later_ns, flags, echo), later_ns + 1)
    assert (here.epoch, there.epoch) == (3, 2)
