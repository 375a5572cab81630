# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A master node as a process of its own; the test plays the server."""

import contextlib

import numpy as np

from pmwvc_core.params import MasterParams, OperatorParams, SafetyParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import WAVE_QOS
from pmwvc_msgs.msg import MasterTrace, Wave
from support.packer import Packer
from support.processes import NodeProcess

MODULE = "pmwvc_master.node"
USER = ("-r", "__ns:=/user1")
FRAME_S = MasterParams().frame_s
# largest change of force in a tick
STEP_N = SafetyParams().max_slew * MasterParams().tick_s + 1e-9


@contextlib.contextmanager
def master(peer, **parameters):
    """A master with a constant operator, seen by ``peer``: trace blocks and waves."""
    values = {"operator": OperatorParams(kind="constant", force=1.0), "channel": "plain"}
    values |= {name.replace("__", "."): value for name, value in parameters.items()}
    blocks = peer.collect(MasterTrace, "/user1/trace")
    waves = peer.collect(Wave, "/user1/wave_up")
    with NodeProcess(MODULE, values, arguments=USER) as process:
        peer.until(lambda: (blocks and waves) or process.process.poll() is not None)
        assert process.process.poll() is None, process.output
        yield process, blocks, waves


class Server:
    """The test as server: answers whenever asked to, well or badly."""

    def __init__(self, peer):
        self.types = messages.live_types()
        self.packer = Packer(42, period=FRAME_S)
        self.out = peer.node.create_publisher(Wave, "/user1/wave_down", WAVE_QOS)
        peer.until(lambda: self.out.get_subscription_count())

    def message(self, wave=0.0):
        packet = self.packer.pack(wave, 0.0, 1_000_000 * self.packer.seq)
        return messages.wave(self.types, packet, 0)

    def answer(self, wave=0.0):
        self.out.publish(self.message(wave))

    def send(self, **fields):
        """A packet with fields changed."""
        message = self.message()
        for name, value in fields.items():
            setattr(message, name, value)
        self.out.publish(message)


def signal(blocks, name):
    return np.concatenate([np.array(getattr(block, name)) for block in blocks])
