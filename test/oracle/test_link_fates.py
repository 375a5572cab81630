# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The fates of packets: of every preset as its distributions say, and as an independent oracle
computes them from the same random numbers.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracle import link_oracle

from pmwvc_core.network.distributions import drawn
from pmwvc_core.network.draws import gilbert_loss
from pmwvc_core.network.effects import mean_s
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams

PACKETS, PERIOD_NS, START_NS = 10_000, 8_000_000, 5_000_000_000
SEED, OTHER_SEED = (11, 0, 0), (12, 0, 0)
ERRORS = 3.0  # standard errors
WAYS = [
    (name, way)
    for name, preset in PRESETS.items()
    for way in (("up", "down") if preset.up != preset.down else ("up",))
]


def params_of(name, way):
    return getattr(PRESETS[name], way)


def times_ns(count=PACKETS):
    return START_NS + PERIOD_NS * np.arange(count, dtype=np.int64)


def driven(params, seed, time_ns):
    """Return the fates of the packets, and those of their copies by packet."""
    link = Link(params, seed=seed)
    sent = [link.send(None, int(now_ns)) for now_ns in time_ns]
    return [each[0] for each in sent], {n: each[1] for n, each in enumerate(sent) if each[1:]}


@cache
def train(name, way):
    return driven(params_of(name, way), SEED, times_ns())


@cache
def computed(name, way, seed):
    return link_oracle.fates(params_of(name, way), seed, times_ns(), ramps(name, times_ns()))


def ramps(name, time_ns):
    """Return the constant delay of each packet of the preset whose delay rises and falls."""
    if name != "torture":
        return None
    phase = ((time_ns - time_ns[0]) * 1e-9) % 0.8
    return np.interp(phase, [0.0, 0.4, 0.8], [0.02, 0.38, 0.02])


def arrays(fates):
    lost = np.array([fate.kind is FateKind.LOST for fate in fates])
    due_ns = np.array([fate.time_due_ns for fate in fates])
    return lost, due_ns, due_ns - np.array([fate.time_in_ns for fate in fates])


def assert_as_computed(fates, copies, wanted):
    lost, due_ns, _ = arrays(fates)
    assert (lost == wanted.lost).all()
    assert np.abs(due_ns - wanted.due_ns).max() <= 2  # rounding of the quantiles to ns
    causes = np.array([int(fate.cause) for fate in fates])
    assert ((causes == Cause.OUTAGE) == wanted.outage).all()
    assert ((causes == Cause.CORRUPTION) == wanted.corrupted).all()
    assert sorted(copies) == np.flatnonzero(wanted.copied).tolist()
    for packet, copy in copies.items():
        assert abs(copy.time_due_ns - wanted.copy_due_ns[packet]) <= 2


@pytest.mark.parametrize("name, way", WAYS)
def test_fates_of_a_preset_are_those_of_the_oracle(name, way):
    assert_as_computed(*train(name, way), computed(name, way, SEED))


def test_another_seed_has_other_fates():
    with pytest.raises(AssertionError):
        assert_as_computed(*train("torture", "up"), computed("torture", "up", OTHER_SEED))


@pytest.mark.parametrize("name, way", WAYS)
def test_loss_and_delay_of_a_preset_are_those_of_its_closed_forms(name, way):
    params, wanted = params_of(name, way), computed(name, way, SEED)
    lost, _, delay_ns = arrays(train(name, way)[0])
    away = np.ones(len(lost), dtype=bool)
    if params.handover_s:  # whose packets are lost besides
        phase = ((times_ns() - START_NS) * 1e-9) % params.handover_s
        away = (phase > 1.0) & (phase < params.handover_s - 1.0)
        assert wanted.outage.any()
    mean, (p, r) = gilbert_loss(params) + params.loss, (params.ge_p, params.ge_r)
    memory = 1.0 - p - r if p else 0.0
    error = np.sqrt(mean * (1.0 - mean) * (1.0 + memory) / (1.0 - memory) / away.sum())
    assert abs(lost[away].mean() - mean) <= ERRORS * error
    edges = np.flatnonzero(np.diff(np.concatenate(([0], lost[away].astype(int), [0]))))
    lengths = edges[1::2] - edges[::2]
    if p and len(lengths):
        error = np.sqrt((1.0 - r) / r**2 / len(lengths))
        assert abs(lengths.mean() - 1.0 / r) <= ERRORS * error
    if drawn(params):
        ramp_s = ramps(name, times_ns()) if name == "torture" else 0.0
        delays = (delay_ns * 1e-9 - wanted.moved_s - ramp_s)[~lost]
        mean = mean_s(params) if name != "torture" else 0.0
        together = 1.0 if not params.slot_max_s else np.sqrt(2.0)  # packets share their slots
        error = together * delays.std() / np.sqrt(len(delays))
        assert abs(delays.mean() - mean) <= ERRORS * error + 1e-9


probabilities = st.sampled_from([0.0, 0.02, 0.3])
correlations = st.sampled_from([0.0, 0.25, 0.9])
gaps_ns = st.lists(st.integers(0, 20_000_000), min_size=30, max_size=60)
any_settings = st.builds(
    LinkParams,
    delay_s=st.floats(0.0, 0.1),
    jitter=st.sampled_from(["uniform", "normal", "pareto", "gamma", "lognormal"]),
    jitter_s=st.sampled_from([0.0, 0.003, 0.02]),
    jitter_shape=st.sampled_from([0.0, 2.5, 4.0]),
    jitter_correlation=correlations,
    loss=probabilities,
    loss_correlation=correlations,
    ge_p=probabilities,
    ge_r=st.floats(0.05, 1.0),
    ge_bad=st.floats(0.0, 1.0),
    ge_good=probabilities,
    duplicate=probabilities,
    duplicate_correlation=correlations,
    corrupt=probabilities,
    corrupt_correlation=correlations,
    slot_min_s=st.just(0.001),
    slot_max_s=st.sampled_from([0.0, 0.01]),
    keep_order=st.just(False),
)


@settings(max_examples=20, deadline=None)
@given(params=any_settings, seed=st.integers(0, 2**31), gaps=gaps_ns)
def test_fates_under_any_settings_are_those_of_the_oracle(params, seed, gaps):
    time_ns = START_NS + np.cumsum(np.array([0, *gaps], dtype=np.int64))
    wanted = link_oracle.fates(params, (seed, 1, 1), time_ns)
    assume(wanted.due_ns.max() - START_NS < 1_000_000_000_000)  # slots are made one by one
    assert_as_computed(*driven(params, (seed, 1, 1), time_ns), wanted)
