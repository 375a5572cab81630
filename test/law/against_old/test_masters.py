# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master ports of both channels as pure functions do what the classes do."""

import random

import numpy as np
import pytest

from pmwvc_core.law.channel.arrivals import StrictArrivals, arrivals_of, start_of
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.channel.playout import PlayoutParams, add
from pmwvc_core.law.port import strict_master  # noqa: F401  # joins the families
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.port.local_model import local_stored_j
from pmwvc_core.law.port.master import (
    port_answer,
    port_applied,
    port_measure,
    port_packet,
    port_send,
    port_signals,
    port_tick,
)  # fmt: skip
from pmwvc_core.law.port.plain_master import PlainEnergies, PlainMaster, PlainMasterParams
from pmwvc_core.law.port.port_filters import NoFilter
from pmwvc_core.law.port.strict_state import (
    Node,
    StrictEnergies,
    StrictMaster,
    StrictMasterParams,
    Under,
)  # fmt: skip
from pmwvc_core.law.position.feedback import NoPosition
from pmwvc_core.law.wave.anti_aliasing import filter_params, resting_filter
from pmwvc_core.law.wave.hold import Hold
from pmwvc_core.law.wave.wave import impedance
from pmwvc_core.made.waves import filters_params, resting_filters
from pmwvc_core.master import strict_port
from pmwvc_core.master.brake import brake_of
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.params import MasterParams
from pmwvc_core.params.port_filters import BankParams, LocalModelParams, VelocityFilterParams
from pmwvc_core.transport.packet import Packer, WavePacket
from pmwvc_core.wave.playout import Playout

NONE = NoFilter(0)
NO_POSITION = NoPosition(0)


def value(vector):
    return vector[0] if len(vector) == 1 else np.array(vector)


def vector(value, axes):
    return tuple(float(v) for v in np.broadcast_to(np.ravel(value), (axes,)))


def same(got, wanted):
    assert np.allclose(np.ravel(got), np.ravel(wanted), rtol=1e-10, atol=1e-11), (got, wanted)


def masters(strict, axes, params, playout):
    zero = (0.0,) * axes
    b = impedance(params.impedance)
    filters = filters_params(params, b)
    resting = resting_filters(params, filters, axes)
    if strict:
        p = StrictMasterParams(b, params.tick_s, filters, NO_POSITION, False, playout)
        s = StrictMaster(
            Node(0.0, 0.0, 0.0, 0.0), resting, NO_POSITION, (zero, zero, zero), zero, zero,
            (resting_counts(0.0),) * axes, zero, Under(zero, zero, True, False), 0.0,
            (False, False), StrictEnergies(0.0, 0.0, 0.0),
        )  # fmt: skip
        return s, p
    filter_ = filter_params(params.filter, tick_s=params.tick_s, rate_drop=params.rate_drop)
    ticks = params.rate_drop if params.ramps else 1
    p = PlainMasterParams(b, params.tick_s, params.frame_s, ticks, filter_, filters, NO_POSITION)
    s = PlainMaster(
        Hold(zero, zero, zero, 0), resting_filter(params.filter, axes, filter_), resting,
        NO_POSITION, (zero, zero, zero), zero, zero, zero, PlainEnergies(0.0, 0.0, 0.0, 0.0, 0.0),
    )  # fmt: skip
    return s, p


def accounts(s, p):
    found, parts = {}, s.filters
    for part in (parts.near, parts.far, parts.force):
        kind = type(part).__name__
        if kind in ("Exact", "Complementary"):
            found["velocity_filter"] = part.kept_j
        if kind == "InForce":
            found["force_velocity_filter"] = part.kept_j
        if kind == "Bank":
            e = part.energies
            names = ("bank_low_in", "bank_low_out", "bank_high_in", "bank_high_out")
            found |= dict(zip(names, e, strict=True))
            found["local_stored"] = local_stored_j(part.local, p.filters.far.local)
            found["local_dissipated"] = part.local.dissipated_j
    return found


LOCAL = LocalModelParams(stiffness=300.0, damping=1.0, acts="above", begins_m=0.0)
FILTERS = {
    "none": {},
    "exact": {"velocity_filter": VelocityFilterParams(kind="exact")},
    "equivalent": {"velocity_filter": VelocityFilterParams(kind="equivalent")},
    "complementary": {"velocity_filter": VelocityFilterParams(kind="complementary")},
    "bank": {"bank": BankParams(kind="dissertation"), "local_model": LOCAL},
    "both": {
        "velocity_filter": VelocityFilterParams(kind="exact"),
        "bank": BankParams(kind="complementary"),
        "local_model": LocalModelParams(stiffness=100.0, damping=2.0),
    },
}


@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("seed", range(4))
def test_every_tick_of_both_is_the_same(strict, axes, seed):
    same_ticks(strict, axes, seed, "none")


@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("filters", list(FILTERS)[1:])
def test_every_tick_with_filters_is_the_same(strict, axes, filters):
    for seed in range(2):
        same_ticks(strict, axes, seed, filters)


def same_ticks(strict, axes, seed, filters):
    luck = random.Random(seed)
    hold = luck.choice(["zoh", "foh"])
    params = MasterParams(impedance=luck.choice([12.5, 40.0]), hold=hold, **FILTERS[filters])
    play = PlayoutParams(0.2, 0.2, luck.choice([0.0, 2e-3]))
    playout = Playout(most_repaid=0.2, rises_s=0.2, store_j=play.store_j)
    packer, brake = Packer(1, period=params.frame_s), brake_of(params)
    if strict:
        old = strict_port.StrictMaster(params, playout, packer, brake)
    else:
        old = WaveMaster(params)
    s, p = masters(strict, axes, params, play)
    zero = (0.0,) * axes
    a = arrivals_of(start_of(True, 0.05, 0.008), zero)
    step = luck.choice([0.0, 2e-5])
    x, xd, f = [0.0] * axes, [0.0] * axes, zero
    seen = set()
    last = zero
    for tick in range(3000):
        xd = [0.995 * v + luck.gauss(0.0, 0.005) for v in xd]
        x = [u + 0.001 * v for u, v in zip(x, xd, strict=True)]
        read = tuple(step * round(u / step) if step else u for u in x)
        v = tuple((q - r) / 0.001 for q, r in zip(read, last, strict=True)) if step else tuple(xd)
        last = read
        if luck.random() < 0.001:
            v = (float("nan"), *v[1:])
        if tick % 8 == 0:
            old.measure(value(read), value(v))
            s = port_measure(s, read, v, p)
            wave = old.send()
            sent_energy = old.account()
            packer.pack(wave, old.position(), 0)
            s, a, sent = port_send(s, a, params.frame_s, tick // 8 + 1, 0.0, p)
            same(sent.wave, vector(wave, axes))
            if strict:
                same(sent.energy_j, sent_energy)
            w = tuple(luck.gauss(0.0, 0.4) for _ in range(axes))
            silent = tick % 3000 > 2700
            short = luck.random() < 0.2
            if luck.random() < 0.9 and not silent and strict:
                paid = luck.choice([0.2, 1.0, 1.5]) * 0.5 * 0.008 * sum(q * q for q in w)
                playout.add(value(tuple(0.008 * q for q in w)), paid, 0.008)
                made = add(a.playout, tuple(0.008 * q for q in w), paid, 0.008)
                a = StrictArrivals(a.silence, made, a.counting, a.position, a.wanted)
            number = tick // 8 + 1
            packet = WavePacket(
                7, number, 0, 0.008, value(w), value(w), 0.0, value(zero), short=short
            )
            old.on_packet(packet)
            s = port_packet(
                s, a,
                Packet(
                    number, 0, 0.008, w, w, 0.0, zero, short, False, False, False, (), 0,
                    False, 0, 0,
                ),
                p,
            )  # fmt: skip
            if silent:
                old.silence()
            else:
                old.receive(value(w))
            s = port_answer(s, w, silent, 0.008, p)
        f_m = old.step(value(read), value(v))
        s, a, got = port_tick(s, a, read, v, p)
        same(got, vector(f_m, axes))
        limited = tuple(max(min(q, 4.0), -4.0) for q in got)
        if luck.random() < 0.3:
            limited = tuple(0.9 * q + 0.1 * r for q, r in zip(limited, f, strict=True))
        if limited == got:
            old.applied(f_m)
        else:
            seen.add("limited")
            old.applied(value(limited))
        f = limited
        s = port_applied(s, limited, p)
        for one, other in zip(port_signals(s), (old.u_m, old.u_m_lp, old.v_m), strict=True):
            same(one, vector(other, axes))
        if strict:
            same(s.node.node_j, old.node_j)
            same(s.node.deficit_j, old.deficit_j)
            if s.node.node_j < -2e-3 - s.node.withheld_j:
                seen.add("waits")
            if s.asks[0] and s.unpaid:
                seen.add("unpaid")
        else:
            same(s.energies.deficit_j, old.deficit_j)
            if s.energies.deficit_j:
                seen.add("deficit")
    if filters != "none":
        kept = accounts(s, p)
        for name, energy in old.accounts.items():
            if name in kept:
                same(kept[name], energy)
                seen.add(name)
    for name in ("u_m", "u_tx", "v_m"):
        same(getattr(s.energies, name), getattr(old, f"energy_{name}"))
    print(seen)
