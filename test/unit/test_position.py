# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback: what it corrects, what it takes for the same place, what it may spend."""

import math

import numpy as np
import pytest
from support.packer import Packer
from support.port_rig import Port

from pmwvc_core.params import FilterParams, MasterParams, PositionParams
from pmwvc_core.transport.packet import FLAG_ANEW

M, TICK_S, FRAME_S = 8, 0.001, 0.008
KINDS = ("printed", "budgeted", "integral")


def params(kind="budgeted", gain=20.0, b=25.0, hold="foh", **position):
    return MasterParams(
        impedance=b,
        rate_drop=M,
        tick_s=TICK_S,
        hold=hold,
        filter=FilterParams(kind="integrate_and_dump"),
        position=PositionParams(feedback=kind, gain=gain, **position),
    )


class Rig:
    """A master, and a server that says what it is told to."""

    def __init__(self, given, epoch=7, axes=1):
        self.port = Port(given, axes=axes)
        self.server = Packer(epoch, period=FRAME_S)
        self.sent = 0

    def frame(self, x, x_s, *, v=0.0, xd=0.0, flags=0, echo=None, silent=False):
        """Run a frame; return the forces of its ticks."""
        self.port.send()
        self.sent += 1
        echo = (self.sent if echo is None else echo, 0, 0)
        self.port.on_packet(self.server.pack(v, x_s, 0, flags=flags, echo=echo))
        if silent:
            self.port.silence()
        else:
            self.port.receive(v)
        forces = []
        for _ in range(M):
            forces.append(self.port.step(x, xd))
            self.port.applied(forces[-1])
        return forces


def saved(rig, joules):
    """Let a port take in energy: a hand that moves on against the damper."""
    speed = math.sqrt(joules / (25.0 * 4 * FRAME_S)) * 3.0
    x = 0.0
    for sign in (1.0, -1.0, 1.0, -1.0):  # to and fro: the mean over a frame is lost
        for _ in range(M):
            rig.port.tick(sign * speed, x=x)
            x += sign * speed * TICK_S
            sign = -sign


def test_published_is_its_equation():
    rig = Rig(params("printed", hold="zoh"))
    rig.frame(0.3, 0.1)
    forces = rig.frame(0.31, 0.102, v=0.05, xd=0.02)
    v_m = 0.05 - 20.0 * (0.31 - 0.102 - 0.2)
    assert forces == pytest.approx([25.0 * 0.02 - math.sqrt(50.0) * v_m] * M, rel=1e-12)
    assert rig.port.v_m == pytest.approx(v_m, rel=1e-12)
    assert rig.port.energies["position_spent"] == pytest.approx(
        (v_m**2 - 0.05**2) / 2 * FRAME_S, rel=1e-9
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_place_a_new_avatar_and_a_new_server_begin_without_a_force(kind):
    rig = Rig(params(kind))
    for _ in range(5):
        assert rig.frame(0.3, 0.1) == [0.0] * M
    assert rig.frame(0.3, -0.5, flags=FLAG_ANEW) == [0.0] * M
    rig.server = Packer(8, period=FRAME_S)
    assert rig.frame(0.3, 0.7, flags=FLAG_ANEW) == [0.0] * M
    saved(rig, 1e-3)
    rig.frame(0.3, 0.7, flags=FLAG_ANEW)
    assert np.all(np.array(rig.frame(0.3, 0.69, flags=FLAG_ANEW)) > 0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_corrected_before_an_answer_and_in_silence(kind):
    rig = Rig(params(kind))
    assert rig.frame(0.3, 0.1, echo=0) == [0.0] * M  # of a packet we do not know
    rig.frame(0.3, 0.1)
    saved(rig, 1e-3)
    rig.frame(0.3, 0.1)
    assert rig.frame(0.3, 0.08, silent=True) == [0.0] * M
    assert rig.frame(0.3, 0.08)[-1] > 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_feedback_can_be_switched_on_while_running(kind):
    rig = Rig(params(kind, gain=0.0))
    for _ in range(3):
        rig.frame(0.3, 0.1)
    assert "position_spent" not in rig.port.energies
    rig.port.configure(params(kind))
    rig.frame(0.3, 0.1)
    assert rig.frame(0.3, 0.1) == [0.0] * M
    assert "position_spent" in rig.port.energies
