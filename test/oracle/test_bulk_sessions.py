# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk give the golden traces: interpreted all that can be run so, some compiled."""

from pathlib import Path

import pytest
import yaml
from support import golden
from support.golden_sessions import MAPPINGS

from pmwvc_core.compiled import compiled
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.bulk.run import can_run, run, session
from pmwvc_core.simulation.bulk.traces import traces_of
from pmwvc_core.simulation.session import simulate_one

CONFIG = Path(__file__).resolve().parents[2] / "pmwvc_bringup" / "config"
NAMES = [name for name in MAPPINGS if can_run(parse_scenario(MAPPINGS[name]))]


def differences(name, loop):
    left = run(parse_scenario(MAPPINGS[name]), loop)
    assert left.whole
    now, was = golden.record_of(traces_of(left)), golden.load(golden.FOLDER / f"{name}.npz")
    return golden.differences(was, now, golden.tolerance_of(name))


@pytest.mark.parametrize("name", NAMES)
def test_a_session_gives_its_golden_traces(name):
    assert differences(name, session) == []


@pytest.mark.parametrize("name", [NAMES[0], NAMES[-1]])
def test_a_compiled_session_gives_its_golden_traces(name):
    assert differences(name, compiled(session)) == []


SCENARIOS = ("carry_16ms", "internet", "wifi_bursty", "blackout_2s", "reorder_storm", "wall")


@pytest.mark.parametrize("channel", ["plain", "zeroing", "strict"])
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_session_in_bulk_is_that_of_virtual_time(name, channel):
    mapping = yaml.safe_load((CONFIG / f"{name}.yaml").read_text("utf-8"))
    scenario = parse_scenario(mapping | {"channel": channel, "duration_s": 4.0})
    left = run(scenario, session)
    assert left.whole
    was, now = golden.record_of(simulate_one(scenario)), golden.record_of(traces_of(left))
    assert golden.differences(was, now, 1e-10) == []
