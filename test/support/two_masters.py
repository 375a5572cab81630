# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A server and two masters as processes, joined by remapping, and what they publish."""

import contextlib

import numpy as np

from pmwvc_core.params import DeviceParams, MasterParams, OperatorParams, SafetyParams
from pmwvc_core.runtime.topics import RECORDED_QOS
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from support.peers import ros
from support.processes import NodeProcess

SIDES = {"user1": -1, "user2": 1}
STEP_N = (
    SafetyParams().max_slew * MasterParams().tick_s + 1e-9
)  # largest change of force in a tick
BILATERAL = {"server.contact": "bilateral", "server.object_damping": 20.0}


def start_server(**parameters):
    given = {name.replace("__", "."): value for name, value in parameters.items()}
    values = {"users": list(SIDES), "channel": "plain"} | given
    return NodeProcess("pmwvc_server.node", values)


def start_master(user, **parameters):
    """A master of a user who presses on the object with 1 N, without a network between."""
    side = SIDES[user]
    values = {
        "channel": "plain",
        "side": side,
        "operator": OperatorParams(kind="constant", force=-side * 1.0),
        "device": DeviceParams(damping=10.0, workspace_m=5.0),  # drifts slowly when let go
    }
    values |= {name.replace("__", "."): value for name, value in parameters.items()}
    ends = [f"wave_{way}:=/server/{user}/wave_{way}" for way in ("up", "down")]
    arguments = ["-r", f"__ns:=/{user}", "-r", ends[0], "-r", ends[1]]
    return NodeProcess("pmwvc_master.node", values, arguments=arguments)


def record(peer, kind, topic):
    """Every message of a trace: also a busy test must not lose one."""
    messages = []
    peer.node.create_subscription(kind, topic, messages.append, RECORDED_QOS)
    return messages


class Session:
    """A server and two masters, what they publish, and waiting for it."""

    def __init__(self, stack, peer, **parameters):
        self.stack, self.peer, self.parameters = stack, peer, parameters
        self.steps = record(peer, ServerTrace, "/server/trace")
        self.blocks = {user: record(peer, MasterTrace, f"/{user}/trace") for user in SIDES}
        self.server = stack.enter_context(start_server(**parameters))
        self.masters = {}
        for user in SIDES:
            self.start(user)

    def start(self, user):
        shared = {k: v for k, v in self.parameters.items() if k in ("controller", "dof")}
        self.masters[user] = self.stack.enter_context(start_master(user, **shared))

    def until_states(self, user1, user2):
        """Wait until both masters are in a state."""
        wanted = {"user1": user1, "user2": user2}
        self.peer.until(
            lambda: all(b and b[-1].state == wanted[u] for u, b in self.blocks.items())
        )

    def steps_more(self, count):
        """Wait for some more steps of the server."""
        seen = len(self.steps)
        self.peer.until(lambda: len(self.steps) >= seen + count)

    def settled(self):
        """Wait until both press with 1 N and nothing moves any more."""

        def rests():
            last = self.steps[-25:]
            return len(last) == 25 and all(
                abs(abs(force) - 1.0) < 0.01 for step in (last[0], last[-1]) for force in step.f_s
            )

        self.peer.until(rests)

    def force(self, user, since=0):
        """Applied force, tick by tick, with the places where ticks are missing."""
        blocks = self.blocks[user][since:]
        force = np.concatenate([np.array(block.f_applied) for block in blocks])
        ticks = np.concatenate(
            [block.first_tick + np.arange(len(block.f_applied)) for block in blocks]
        )
        return force, np.diff(ticks) == 1


@contextlib.contextmanager
def session(**parameters):
    with contextlib.ExitStack() as stack:
        peer = stack.enter_context(ros())
        yield Session(stack, peer, **parameters)


def no_step_of_force(run, user, since=0):
    force, consecutive = run.force(user, since)
    return np.abs(np.diff(force))[consecutive].max() <= STEP_N
