# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The size of a recording on disk, as announced before it is made."""

import pytest
from support import handmade

from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import bytes_per_message, live_bytes_per_minute

RECORD = 47


@pytest.mark.parametrize("users", [1, 2, 5])
@pytest.mark.parametrize("dof", [1, 3])
def test_messages_have_the_sizes_that_are_reckoned_with(tmp_path, users, dof):
    scenario = handmade.scenario(duration_s=0.2, dof=dof, users=users)
    record_traces(tmp_path, handmade.session(duration_s=0.2, users=users, dof=dof), scenario)
    sizes = {m.topic: len(m.data) for m in messages(tmp_path / "session.mcap", Salvage())}
    topics = "/user1/trace", "/server/trace", "/user1/wave_up"
    expected = dict(zip(topics, bytes_per_message(scenario, scenario.users[0]), strict=True))
    for topic, reckoned in expected.items():
        assert sizes[topic] + RECORD == pytest.approx(reckoned, rel=0.1)


def test_a_further_user_takes_what_a_user_takes():
    sizes = [live_bytes_per_minute(handmade.scenario(users=n)) / 2**20 for n in (1, 2, 8)]
    assert sizes[1] == pytest.approx(13.3, rel=0.1)  # measured live: 13.3 MiB a minute
    assert sizes[2] - sizes[1] == pytest.approx(6 * (sizes[1] - sizes[0]))
