# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled, both ends of the controllers without waves are what they are as they stand."""

import numpy as np
import pytest
from support.laws import assert_same, in_bulk

from pmwvc_core.law.channel.arrivals import ArrivalsParams, arrive, start_of
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import Nothing
from pmwvc_core.law.motion import Body, body_law
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_measure,
    port_send,
    port_tick,
)
from pmwvc_core.law.server.contacts import Avatar
from pmwvc_core.law.server.server_port import (
    Came,
    SharedScene,
    UserPort,
    environment_step,
    joined,
    left,
)
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.law.without_waves import couplings, pspm, tdpa
from pmwvc_core.law.without_waves.ends import AvatarEndParams, DeviceEnd, DeviceEndParams
from pmwvc_core.made.server import contact_of
from pmwvc_core.params import ContactParams
from pmwvc_core.params.server import TdpaParams

H, TICK_S = 0.008, 0.001


def frame(end, arrivals, e, packet, x, xd, silent, p, q, rules):
    """Run a frame of one user whose avatar leaves and joins again."""
    arrivals = arrive(arrivals, packet, packet.sent_ns, rules)
    end = port_measure(end, x, xd, p)
    end, _, sent = port_send(end, arrivals, H, packet.number, 0.0, p)
    came = Came(sent.wave, sent.position, False, max(sent.energy_j, 0.0), ())
    e = environment_step(q, e, (came,))
    one, lost_j = left(e.ports[0])
    one, _ = joined(one, sent.position, e.body)
    end = port_answer(end, arrivals, packet, packet.wave, silent, H, p)
    end, _, f = port_tick(end, arrivals, x, xd, p)
    end = port_applied(end, f, p)
    return end, arrivals, e, one, f, lost_j, arrivals.received_j


@pytest.mark.parametrize("kind", ["direct", "virtual_coupling", "tdpa", "pspm"])
@pytest.mark.parametrize("axes", [1, 3])
def test_both_ends(kind: str, axes: int) -> None:
    nothing, nobody = (0.0,) * axes, Nothing(0)
    spring = pspm.ModulatedSpring(nothing, 0.005)
    state, law, kept = {
        "direct": (
            couplings.Held(nothing),
            couplings.Direct(0),
            nobody,
        ),
        "virtual_coupling": (
            couplings.AvatarSeen(nothing, nothing),
            couplings.VirtualCoupling(300.0, 3.0),
            nobody,
        ),
        "tdpa": (
            tdpa.TdpaDevice(nothing, nothing), tdpa.tdpa_law(TdpaParams(), TICK_S), tdpa.Observer()
        ),
        "pspm": (
            pspm.PspmDevice(spring, nothing), pspm.Pspm(500.0, 2.0, 0.005), spring,
        ),
    }[kind]  # fmt: skip
    contact = contact_of(ContactParams(), side=-1, size=0.1, axes=axes)
    avatar = Avatar(False, impedance(25.0), nothing, nothing, nothing, contact, nothing)
    port = UserPort(avatar, kept, nothing, nothing, nothing, 0.0, 0.0, -1.0, ())
    body = Body(nothing, nothing)
    port, _ = joined(port, (-0.06, *nothing[1:]), body)
    e = SharedScene((port,), body, 0.0, 0)
    end, p = DeviceEnd(nothing, nothing, state), DeviceEndParams(TICK_S, law)
    q = AvatarEndParams((law,), body_law(0.5, 1.0, H), kind in ("virtual_coupling", "pspm"))
    rules = ArrivalsParams(0.05, 1.0, False, False, PlayoutParams(1.0, 0.1, 0.0))
    arrivals = start_of(False, axes, 0.05, H)
    rng, bulk = np.random.default_rng(axes), in_bulk(frame)
    energy_j, x = 0.0, np.array((-0.06, *nothing[1:]))
    for n in range(200):
        energy_j += 1e-4 * float(rng.random())
        xd = rng.normal(size=axes) * 0.3
        xd[0] += 0.3 * np.sin(0.05 * n)
        x = x + H * xd
        flags = (False, False, False, False)
        wave = tuple((x + rng.normal(size=axes) * 0.01).tolist())
        packet = Packet(
            n + 1, n, H, wave, nothing, energy_j, wave, *flags, (), 0, n in (0, 90), 0, 0
        )
        given = (
            end, arrivals, e, packet, tuple(x.tolist()), tuple(xd.tolist()),
            bool(rng.random() < 0.1), p, q, rules,
        )  # fmt: skip
        after = frame(*given)
        assert_same(bulk(*given), after, f"{kind} {n}")
        end, arrivals, e = after[:3]
        if n % 50 == 49:
            e = SharedScene((after[3],), e.body, e.dissipated_j, 0)
