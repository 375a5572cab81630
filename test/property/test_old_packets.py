# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Old packets are never believed again: what a sender moved and paid counts once, whatever comes.

Delays up to 5 s, loss, copies, packets that somebody plays back, forged ones whose sums fall,
numbers that run out, senders that leave, are started again and come back. What may be given out is
reckoned here from the packets that were really made and have come. The control is a receiver that
believes eight packets in a row during a silence.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.old_packets import Believing, World, plain, strict
from support.simulated import least_j, simulated

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_bringup import scenarios as files
from pmwvc_core.simulation.session import SteppedSession

LEAST_J, LEAST = -1e-9, -1e-9
PERIOD_NS = 8_000_000


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), forges=st.booleans(), make=st.sampled_from((strict, plain)))
def test_what_was_moved_and_paid_counts_once_in_order_and_the_true_sender_is_followed(
    seed, forges, make
):
    world = World(seed, make(), forges=forges).run()
    assert world.least_j >= LEAST_J
    assert world.least >= LEAST or forges  # which moves the avatar, in an open session
    assert world.in_order or forges
    assert world.there and world.inbox.epoch == world.epoch
    assert len(world.made) - world.newest <= 4


def test_a_receiver_that_believes_old_packets_counts_them_again():
    """The control."""
    found = [World(seed, strict(Believing)).run() for seed in range(8)]
    assert min(world.least_j for world in found) < -1e-3
    assert min(world.least for world in found) < -1e-2
    assert not all(world.in_order for world in found)


PATHS = {
    "a slow path, then none": (
        "link.up.keep_order=false",
        "user1.link.up.schedule=2 delay_s=2.2; 2.3 base; 4.2 outage; 4.6 base",
    ),
    "a slow path that a fast one overtakes, which fails": (
        "link.keep_order=false",
        "link.schedule=2 delay_s=0.4; 4 base; 4.06 outage; 4.5 base",
    ),
}


def carried(*texts):
    return files.load("carry_16ms", settings_texts=texts, duration_s=8.0)


def check_undisturbed(traces, scenario):
    """Every balance is kept, and distance and grip end as undisturbed."""
    calm = simulated(carried())
    assert min(least_j(entry) for entry in user_energies(traces, scenario)) >= LEAST_J
    for user, other, x_s, x_o in zip(
        traces.users, calm.users, traces.server.x_s, calm.server.x_s, strict=True
    ):
        found, usual = (u.x_m[-1, 0] - x[-1, 0] for u, x in ((user, x_s), (other, x_o)))
        assert found == pytest.approx(usual, abs=0.5e-3)
        assert user.f_applied[-1, 0] == pytest.approx(other.f_applied[-1, 0], abs=0.05)


@pytest.mark.parametrize("texts", PATHS.values(), ids=PATHS.keys())
def test_packets_of_a_slow_path_count_once_in_a_carry(texts):
    scenario = carried(*texts)
    check_undisturbed(simulated(scenario), scenario)


def with_replay(scenario, packets, begin_ns):
    """Return the session in which the first user's first packets after 2 s are played back, one a
    step, from an instant on.
    """
    batch = SteppedSession(scenario)
    link, heard = batch.users[0].up, []
    collect = link.collect

    def collected(now_ns):
        arrived = collect(now_ns)
        heard.extend(p for p in arrived if now_ns > 2 * 10**9)
        nth = (now_ns - begin_ns) // PERIOD_NS
        return [*arrived, heard[nth]] if 0 <= nth < packets else arrived

    link.collect = collected
    batch.run(lambda ratio: None)
    return batch.traces()


def test_packets_played_back_in_an_outage_move_nobody():
    scenario = carried("user1.link.up.schedule=4 outage; 4.5 base")
    traces = with_replay(scenario, 40, 4_100_000_000 // PERIOD_NS * PERIOD_NS)
    check_undisturbed(traces, scenario)
    for user, other in zip(traces.users, simulated(scenario).users, strict=True):
        np.testing.assert_array_equal(user.f_applied, other.f_applied)
