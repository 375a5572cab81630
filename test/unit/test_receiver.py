# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver: every verdict by name, what it gives out, and its choice among several senders."""

import dataclasses
import math

import numpy as np
import pytest
from support.packer import Packer

from pmwvc_core.transport.packet import FLAG_CHALLENGE, FLAG_LEAVING, Receipt
from pmwvc_core.transport.receiver import AHEAD, Receiver

PERIOD_S = 0.008
PERIOD_NS = 8_000_000


def receiver(**changes):
    settings = {"dof": 1, "period_s": PERIOD_S, "timeout_s": 0.03} | changes
    return Receiver(settings.pop("dof"), **settings)


def taken(inbox):
    """Return the newest wave accepted."""
    return 0.0 if inbox.newest is None else inbox.newest.wave


def stream(count, *, epoch=1, start_ns=0):
    """Return packets that carry the waves 1, 2, 3..., one period apart."""
    packer = Packer(epoch, period=PERIOD_S)
    return [packer.pack(float(n + 1), 0.1 * n, start_ns + n * PERIOD_NS) for n in range(count)]


def proving(packet, sent_ns):
    """Return a packet that echoes one that was sent to it at an instant."""
    return dataclasses.replace(packet, echo_seq=1, echo_sent_ns=sent_ns)


def test_an_echo_of_what_was_never_sent_yet_proves_nothing():
    inbox = receiver()
    inbox.push(stream(1)[0], 0)
    (new,) = stream(1, epoch=2)
    assert inbox.push(proving(new, 1 << 62), 10**9) is Receipt.STRANGER


@pytest.mark.parametrize(
    "change, verdict",
    [
        ({"wave": math.nan}, Receipt.NOT_FINITE),
        ({"integral": math.inf}, Receipt.NOT_FINITE),
        ({"energy": -math.inf}, Receipt.NOT_FINITE),
        ({"position": math.nan}, Receipt.NOT_FINITE),
        ({"period": math.nan}, Receipt.NOT_FINITE),
        ({"wave": np.array([1.0, math.nan])}, Receipt.NOT_FINITE),
        ({"wave": np.array([1.0, 2.0])}, Receipt.WRONG_LENGTH),
        ({"wave": np.array([])}, Receipt.WRONG_LENGTH),
        ({"position": np.array([1.0, 2.0])}, Receipt.WRONG_LENGTH),
        ({"wave": np.array(1.0)}, Receipt.WRONG_LENGTH),
        ({"period": 0.004}, Receipt.WRONG_PERIOD),
        ({"period": 0.0}, Receipt.WRONG_PERIOD),
        ({"wave": 10.1}, Receipt.TOO_LARGE),
        ({"wave": -10.1}, Receipt.TOO_LARGE),
        ({"seq": 0}, Receipt.MALFORMED),
        ({"seq": 1 << 32}, Receipt.MALFORMED),
    ],
)
def test_what_is_wrong_with_a_packet_is_named_and_the_packet_dropped(change, verdict):
    inbox = receiver(max_wave=10.0)
    good, other = stream(2)
    inbox.push(good, 0)
    assert inbox.push(dataclasses.replace(other, **change), 1) is verdict
    assert inbox.counts[verdict] == 1
    assert taken(inbox) == 1.0
    assert inbox.push(other, 3) is Receipt.ACCEPTED


def test_the_zero_of_a_start_fits_any_number_of_axes():
    inbox = receiver(dof=3)
    packer = Packer(1, period=PERIOD_S)
    assert inbox.push(packer.pack(0.0, 0.0, 0), 0) is Receipt.NEW_EPOCH
    assert inbox.push(packer.pack(np.ones(3), np.zeros(3), 1), 1) is Receipt.ACCEPTED
    assert inbox.push(packer.pack(1.0, np.zeros(3), 2), 2) is Receipt.WRONG_LENGTH


@pytest.mark.parametrize("timeout_s, silence_ns", [(0.03, 30_000_000), (0.001, 3 * PERIOD_NS)])
def test_silence_begins_after_the_timeout_or_three_periods(timeout_s, silence_ns):
    inbox = receiver(timeout_s=timeout_s)
    inbox.push(stream(1)[0], 1000)
    assert not inbox.silent(1000 + silence_ns)
    assert inbox.silent(1000 + silence_ns + 1)
    assert inbox.accepted_ns == 1000


@pytest.mark.parametrize(
    "poison, refused",
    [
        ({"seq": (1 << 32) - 1}, 0),
        ({"seq": AHEAD + 2}, 0),
        ({"seq": 1000}, 5),
        ({"sent_ns": 1 << 62}, 0),
    ],
)
def test_one_poisoned_packet_cannot_lock_the_receiver(poison, refused):
    """The sender echoes what it got a round trip of 40 ms ago."""
    inbox = receiver()
    packets = stream(40)
    inbox.push(packets[0], 0)
    inbox.push(dataclasses.replace(packets[1], **poison), PERIOD_NS)
    verdicts = []
    for n, packet in enumerate(packets[2:], start=2):
        verdicts.append(inbox.push(proving(packet, (n - 5) * PERIOD_NS), n * PERIOD_NS))
    # until one was made after the poisoned one came
    assert verdicts == [Receipt.REORDERED] * refused + [Receipt.ACCEPTED] * (38 - refused)
    assert taken(inbox) == 40.0


def test_a_sender_that_has_left_comes_back_only_by_a_proof():
    inbox = receiver()
    packets = stream(20)
    inbox.push(packets[0], 0)
    inbox.push(dataclasses.replace(packets[10], flags=FLAG_LEAVING), 1)
    for n, packet in enumerate([*packets[1:10], *packets[11:]]):
        assert inbox.push(packet, 10**9 + n) is Receipt.STALE
    assert inbox.challenges(10**9 + 30) and taken(inbox) == 11.0
    assert inbox.push(proving(packets[12], 10**9 + 30), 10**9 + 40) is Receipt.ACCEPTED


def test_a_challenge_is_heard_and_never_followed():
    inbox = receiver()
    challenge = dataclasses.replace(stream(1)[0], flags=FLAG_CHALLENGE)
    assert inbox.push(challenge, 50) is Receipt.STRANGER
    assert inbox.newest is None
    assert inbox.echo(80) == (1, 0, 30)


def test_the_round_trip_needs_no_common_clock():
    # Two clocks 10^12 ns apart; 3 ms there, 5 ms back, 2 ms waiting.
    here, there = receiver(), receiver()
    offset = 10**12
    out = Packer(1, period=PERIOD_S).pack(0.0, 0.0, 1_000_000)
    there.push(out, 4_000_000 + offset)
    sent_back = 6_000_000 + offset
    back = Packer(2, period=PERIOD_S).pack(0.0, 0.0, sent_back, echo=there.echo(sent_back))
    here.push(back, 11_000_000)
    assert here.round_trip_s == pytest.approx(0.008)


@pytest.mark.parametrize("echo", [(0, 0, 0), (1, 10**9, 0), (1, -(10**15), 0), (1, 0, -(10**20))])
def test_an_impossible_echo_is_not_a_round_trip(echo):
    inbox = receiver()
    inbox.push(Packer(2, period=PERIOD_S).pack(0.0, 0.0, 0, echo=echo), 1000)
    assert inbox.round_trip_s is None


ROUND_TRIP_NS = 5 * PERIOD_NS
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


MIDDLE_NS = SECOND_NS // 2


@pytest.mark.parametrize(
    ("senders", "taken_ms"),
    [
        ((Sender(1), Sender(2, begin_ns=1000)), None),  # while the first one sends
        # silent 30 ms after its last packet
        ((Sender(1, end_ns=SECOND_NS), Sender(2, begin_ns=MIDDLE_NS)), (1022, 1040)),
        ((Sender(1, end_ns=SECOND_NS), Sender(2, begin_ns=MIDDLE_NS, hears=False)), None),
        # a stray that was there first
        (
            (Sender(1, every_ns=100_000_000, hears=False), Sender(2, begin_ns=MIDDLE_NS)),
            (500, 600),
        ),
    ],
    ids=["two at full rate", "after silence", "played back", "stray"],
)
def test_another_sender_takes_over_after_silence_and_only_if_it_hears(senders, taken_ms):
    found = followed(receiver(), *senders)
    if taken_ms is None:
        assert {epoch for _, epoch in found} == {1}
        return
    taken = next(now for now, epoch in found if epoch == 2)
    assert taken_ms[0] < taken / 1e6 <= taken_ms[1]
    assert {epoch for now, epoch in found if now > taken} == {2}


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
