# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The controllers without waves as pure functions do what the classes do, at both ends."""

import random

import numpy as np
import pytest
from support.laws import assert_same, old_form

from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.law.channel.arrivals import (
    ArrivalsParams,
    arrivals_of,
    arrive,
    received_j,
    start_of,
)
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_measure,
    port_packet,
    port_send,
    port_tick,
)
from pmwvc_core.law.server.avatar import Avatar
from pmwvc_core.law.server.body import Body, body_law, wall_law
from pmwvc_core.law.server.energies import potential_j
from pmwvc_core.law.server.server_port import (
    Environment,
    Sums,
    UserPort,
    environment_step,
    joined,
    left,
)
from pmwvc_core.law.server_step import Came
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.law.without_waves.avatar_end import AvatarEndParams
from pmwvc_core.made.server import contact_of
from pmwvc_core.made.without_waves import CONTROLLERS, device_params, resting_device_end
from pmwvc_core.params import BaselineParams, ContactParams, MasterParams, ServerParams
from pmwvc_core.params.baselines import PspmParams, TdpaParams
from pmwvc_core.transport.packet import WavePacket

TICK_S, M = 0.001, 8
FRAME_S = TICK_S * M
RULES = ArrivalsParams(0.05, 1.0, False, False, PlayoutParams(1.0, 0.1, 0.0))
KINDS = ("direct", "virtual_coupling", "tdpa", "pspm")


def at_device(kind, axes, baseline):
    """Return state and parameters of a device's end."""
    return resting_device_end(kind, baseline, axes), device_params(kind, baseline, TICK_S)


class Way:
    """One direction of a link that delays and loses packets; its sender may start again."""

    def __init__(self, luck, axes):
        self.luck, self.flying, self.number, self.life = luck, [], 0, 1
        self.arrivals = arrivals_of(start_of(False, 0.05, FRAME_S), (0.0,) * axes)
        self.newest = self.old_newest = None
        self.followed = 0

    def send(self, n, wave, position, energy_j):
        self.number += 1
        if self.luck.random() > 0.2:
            packet = (self.life, self.number, n, wave, position, energy_j)
            self.flying.append((n + self.luck.choice([1, 2, 3]), packet))

    def take(self, n):
        """Return whether a packet has come, to both forms."""
        due = sorted(p for at, p in self.flying if at <= n)
        self.flying = [(at, p) for at, p in self.flying if at > n]
        if due and due[-1][0] != self.followed:
            due = due[-1:]  # what comes with the first packet of a life, the classes do not count
        for life, number, sent, wave, position, energy_j in due:
            if self.newest is not None and (life, number) < (self.followed, self.newest.number):
                continue
            fresh = life != self.followed
            self.followed = life
            flags = (False, False, False, False)
            self.newest = Packet(
                number,
                sent,
                FRAME_S,
                wave,
                position,
                energy_j,
                position,
                *flags,
                (),
                0,
                fresh,
                0,
                life,
            )
            self.arrivals = arrive(self.arrivals, self.newest, n, RULES)
            self.old_newest = WavePacket(
                epoch=life, seq=number, sent_ns=sent, period=FRAME_S, wave=old_form(wave),
                integral=old_form(position), energy=energy_j, position=old_form(position), flags=0,
            )  # fmt: skip
        return self.newest is not None


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(3))
def test_both_ends_of_a_lossy_link(kind: str, axes: int, seed: int) -> None:
    luck, rng = random.Random(seed), np.random.default_rng(seed)
    baseline = BaselineParams(
        tdpa=TdpaParams(fade_s=luck.choice([0.0, 0.005]), damping=luck.choice([0.0, 2.0])),
        pspm=PspmParams(initial_j=luck.choice([0.0, 0.005]), cap_j=0.005),
    )
    contact = ContactParams(
        contact=luck.choice(["grip", "bilateral"]), contact_stiffness=500.0,
        contact_damping=luck.choice([0.0, 2.0]),
    )  # fmt: skip
    wall = seed % 3 == 2
    params = ServerParams(environment="wall" if wall else "cube", period_s=FRAME_S)
    nothing, size = (0.0,) * axes, params.object_size_m
    master = make_master(kind, MasterParams(rate_drop=M), baseline)
    server = make_server(
        kind, params, [contact] * 2, [25.0] * 2, dof=axes, sides=[-1, 1], baselines=[baseline] * 2
    )
    s, p = at_device(kind, axes, baseline)
    body = wall_law(FRAME_S) if wall else body_law(
        params.object_mass, params.object_damping, FRAME_S
    )  # fmt: skip
    ports = tuple(
        UserPort(
            Avatar(False, impedance(25.0), nothing, nothing, nothing,
                   contact_of(contact, side=side, size=size, axes=axes), nothing),
            CONTROLLERS[kind].at_avatar(baseline, axes), nothing, nothing, nothing,
            Sums(0.0, 0.0, -1.0), (),
        )
        for side in (-1, 1)
    )  # fmt: skip
    q = AvatarEndParams((p.law, p.law), body, kind in ("virtual_coupling", "pspm"))
    e = Environment(ports, Body(nothing, nothing), 0.0, 0)
    up, down = Way(luck, axes), Way(luck, axes)
    start = (-0.5 * size - 0.005, *nothing[1:])
    x, speed = np.array(start), np.zeros(axes)
    other = (0.5 * size + 0.002, *nothing[1:])

    def place(e, i, one, lost_j):
        ports = (one, e.ports[1]) if i == 0 else (e.ports[0], one)
        return Environment(ports, e.body, e.dissipated_j + lost_j, 0)

    for n in range(400):
        if n == 150:
            down.life, down.number = down.life + 1, 0
            up.life, up.number = up.life + 1, 0
        motion = tuple(x.tolist()), tuple(speed.tolist())
        old_motion = old_form(motion[0]), old_form(motion[1])
        master.measure(*old_motion)
        s = port_measure(s, *motion, p)
        s, _, sent = port_send(s, 0, FRAME_S, n, 0.0, p)
        assert_same((sent.wave, sent.position), (master.send(), master.position()))
        account = master.account()
        assert_same(sent.energy_j, -1.0 if account is None else account)
        up.send(n, sent.wave, sent.position, sent.energy_j)
        if up.take(n):
            if not server.present[0]:
                server.join(0, up.old_newest.position)
                e = place(e, 0, *joined(e.ports[0], up.newest.position, e.body))
            if n == 100:
                server.join(1, old_form(other))
                e = place(e, 1, *joined(e.ports[1], other, e.body))
            if n == 250:
                server.leave(0)
                e = place(e, 0, *left(e.ports[0]))
                server.join(0, up.old_newest.position)
                e = place(e, 0, *joined(e.ports[0], up.newest.position, e.body))
            server.on_packet(0, up.old_newest)
            back = server.step(
                [
                    (up.old_newest.position, up.old_newest.wave),
                    (old_form(other), old_form(nothing)),
                ]
            )
            gained_j = received_j(up.arrivals)
            came = (
                Came(up.newest.wave, up.newest.position, False, gained_j),
                Came(nothing, other, False, 0.0),
            )
            e = environment_step(q, e, came)
            for one, before, wave in zip(e.ports, server.ports, back, strict=True):
                if one.avatar.present:
                    assert_same(
                        (one.v_s, one.avatar.f, one.avatar.xd, one.x_s),
                        (wave, before.f_s, before.xd_s, before.x_s),
                    )
                    sums = one.sums
                    assert_same((sums.u_j, sums.v_j), (before.energy_u_s, before.energy_v_s))
                    assert_same(sums.account_j, -1.0 if before.account is None else before.account)
            assert_same(e.dissipated_j, server.dissipated)
            assert_same(potential_j(e), server.potential)
            port = e.ports[0]
            down.send(n, port.v_s, port.x_s, port.sums.account_j)
        silent = not down.take(n) or 200 < n < 220
        if down.newest is not None:
            master.on_packet(down.old_newest)
            s = port_packet(s, down.arrivals, down.newest, p)
        if silent:
            master.silence()
        else:
            master.receive(down.old_newest.wave)
        wave = nothing if down.newest is None else down.newest.wave
        s = port_answer(s, wave, silent, FRAME_S, p)
        for tick in range(M):
            asked = master.step(old_form(tuple(x.tolist())), old_form(tuple(speed.tolist())))
            s, _, f_m = port_tick(s, 0, tuple(x.tolist()), tuple(speed.tolist()), p)
            assert_same(f_m, np.broadcast_to(asked, (axes,)), f"{n} {tick}")
            f = tuple(v * luck.choice([1.0, 1.0, 1.0, 0.3]) for v in f_m)
            master.applied(old_form(f))
            s = port_applied(s, f, p)
            x = x + TICK_S * speed
            speed = 0.99 * speed + 0.01 * rng.normal(size=axes) + 0.002 * np.sin(0.05 * n)
        assert_same((s.given_j, s.taken_j), (master.energy_u_m, master.energy_v_m))
