# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hundreds of joins and leaves at a server, in virtual time: nothing grows."""

import gc
import pickle

import pytest
from support.packer import Packer

from pmwvc_bringup import scenarios as files
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame import Presence
from pmwvc_core.law.server.contacts import contact_energy
from pmwvc_core.transport.packet import FLAG_LEAVING

STEP_NS = 8_000_000


class Server:
    """A server whose users come and go, each time with a new life."""

    def __init__(self, channel):
        texts = [f"channel={channel}"]
        self.step_ = ServerEnd(files.load("carry_16ms", settings_texts=texts))
        self.now_ns = self.lives = 0
        self.echo = (0, 0, 0)

    def step(self, *packets):
        self.now_ns += STEP_NS
        (answer, _), _ = self.step_.tick(self.now_ns, [list(packets), []])
        self.echo = (answer.seq, answer.sent_ns, 0) if answer else (0, 0, 0)

    def visit(self, *, goodbye=True):
        """Join, send a wave, and leave with a last packet, or without one."""
        self.lives += 1
        packer = Packer(self.lives, period=0.008)
        for wave in (0.0, 0.3, 0.1):
            self.step(packer.pack(wave, -0.03, self.now_ns, echo=self.echo))
        assert self.step_.presence[0] is Presence.COUPLED
        if goodbye:
            self.step(packer.pack(0.0, -0.03, self.now_ns, FLAG_LEAVING))
        else:
            self.now_ns += round((self.step_.p.release_s + 1.0) * 1e9)
            self.step()
        assert self.step_.presence[0] is Presence.ABSENT

    def size(self):
        """Objects of the process, and bytes of the server's state."""
        gc.collect()
        return len(gc.get_objects()), len(pickle.dumps(self.step_.s))


@pytest.mark.parametrize("channel", ["strict", "plain"])
def test_hundreds_of_joins_and_leaves_leave_nothing_behind(channel):
    server = Server(channel)
    for visit in range(200):
        server.visit(goodbye=visit % 2 == 0)
    objects, state = server.size()
    for visit in range(600):
        server.visit(goodbye=visit % 2 == 0)
    more, later = server.size()
    assert more - objects < 50  # one object a visit would be 600
    assert later - state < 0.1 * state  # numbers of packets and times have more digits
    assert contact_energy(server.step_.s.environment.ports[0].avatar.contact) == 0.0


def test_what_is_kept_of_every_visit_is_seen():
    """The control."""
    server, kept = Server("strict"), []
    server.visit()
    objects, _ = server.size()
    for _ in range(100):
        server.visit()
        kept.append(server.step_.s)
    assert server.size()[0] - objects >= 100
