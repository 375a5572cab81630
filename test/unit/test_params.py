# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every parameter of a scenario: right values come back equal from its file, from the files of its
nodes and from the file again; wrong ones are refused by name.
"""

import math

import pytest
import yaml

from pmwvc_core.errors import ScenarioError
from pmwvc_core.params.fields import parameter
from pmwvc_core.params.names import flat_mapping
from pmwvc_core.runtime import parameter_values as nodes
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import PARAMETERS

BASE = {"name": "one", "duration_s": 5.0, "controller": "pmwvc", "channel": "strict", "users": 1}
OF_LINK = {"jitter_quantiles": "0:0.001 1:0.02", "schedule": "5 outage; 6 base", "effects": ""}
TEXTS = {  # of parameters that have a form
    "device.axes": "y -x z",
    "changes": "2 server.object_mass=1",
    "disturbances": "6 kill server; 7 start user1",
    "server.environment": "wall",
    **dict.fromkeys(("master.impedance_matrix", "server.impedance_matrix"), "30"),
    **{f"link.{way}.{name}": text for way in ("up", "down") for name, text in OF_LINK.items()},
}
BESIDE = {  # what a value needs beside it; of a link below its own name
    "safety.damper_velocity": {"safety.fault_velocity": 20.0},
    "safety.fault_velocity": {"safety.damper_velocity": 1e-4},
    "server.scene": {"server.environment": "body"},
    "task.sideways_m": {"dof": 2},
    "task.upwards_m": {"dof": 3},
    "operator.kind": {"operator.file": "push.csv"},
    "master.tick_s": {"server.period_s": 1.0},
    "master.filter.kind": {"master.filter.stop_hz": 40.0},
    "master.filter.pole_rad_s": {"master.filter.kind": "first_order"},
    "master.filter.cutoff_hz": {"master.filter.kind": "first_order"},
    "master.velocity_filter.alpha": {
        "master.velocity_filter.order": 1,
        "master.velocity_filter.kind": "exact",
    },
    "master.bank.high_stop_db": {"master.bank.high_pass_db": 1e-6},
    "master.bank.high_pass_hz": {"master.bank.high_stop_hz": 1e-6},
    "master.bank.low_stop_hz": {"master.bank.low_pass_hz": 1e-6},
    "master.bank.low_stop_db": {"master.bank.low_pass_db": 1e-6},
    "master.position.storage_j": {"master.position.most_j": 10.0},
    "master.contact_impedance": {"master.impedance": 0.01},
    "jitter": {"jitter_quantiles": "0:0 1:0.1", "trace_file": "delays.csv"},
    "reorder": {"keep_order": False},
    "slot_min_s": {"slot_max_s": 10.0},
    "handover_outage_min_s": {"handover_outage_max_s": 60.0},
}


def given(name, value):
    """Return the file of a scenario with a value, and what that needs."""
    group, _, field = name.rpartition(".")
    own = BESIDE.get(name, {})
    if group.startswith("link."):
        own = {f"{group}.{other}": needed for other, needed in BESIDE.get(field, {}).items()}
    return {**BASE, **own, shown(name): value}


def shown(name):
    """Return the name of a parameter in a file."""
    return f"user1.{name}" if name == "side" else name


def right(name):
    """Return values that a parameter may have: its ends, all its names, a text in its form."""
    spec = PARAMETERS[name].spec
    if name in TEXTS or spec.kind is str:
        return [TEXTS[name]] if name in TEXTS else [*spec.choices] or ["text"]
    if spec.kind is bool:
        return [False, True]
    if spec.choices:
        return [*spec.choices]
    least = spec.low if spec.above is None else spec.above + 1e-3
    most = spec.high if spec.below is None else spec.below - 1e-3
    ends = [spec.kind(0.5 if end is None else end) for end in (least, most)]
    return [*ends, None] if spec.optional else ends


def wrong(name):
    """Return values that a parameter may not have."""
    spec = PARAMETERS[name].spec
    if spec.kind is str:
        return [1.5, [1], *(["no such name"] if spec.choices else [])]
    if spec.kind is bool:
        return ["perhaps", 2.5, None]
    step = 1 if spec.kind is int else 1e-9
    found = [math.nan, math.inf, "fast", True, [1.0], *([] if spec.optional else [None])]
    found += [end for end in (spec.above, spec.below) if end is not None]
    found += [] if spec.low is None else [spec.low - step]
    found += [] if spec.high is None else [spec.high * (1 + 1e-9) + step]
    return found + [2.5] * (spec.kind is int)


def written(values):
    """Return what a file of these values holds."""
    return yaml.load(yaml.dump(values, Dumper=yaml.CSafeDumper), Loader=yaml.CSafeLoader)


def of_nodes(scenario):
    """Return a scenario's file, put together from what the files of its nodes hold."""
    found = {name: value for name, value in scenario.flat().items() if "." not in name}
    tables = [(scenario, "", nodes.SHARED_AT_SERVER)]
    for user in scenario.users:
        found[f"{user.name}.side"] = user.side
        tables += [(user, user.name, nodes.USER_AT_MASTER), (user, user.name, nodes.USER_AT_NETEM)]
    for owner, start, shares in tables:
        held = written(nodes.to_ros_yaml(nodes.given(shares, owner, start)))
        held = flat_mapping(held["/**"]["ros__parameters"])
        taken = nodes.taken_back(shares, held, start)
        found |= {f"{start}.{name}" if start else name: value for name, value in taken.items()}
    return found


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_right_value_comes_back_equal_from_file_nodes_and_file(name):
    assert PARAMETERS[name].spec.description and TEXTS.keys() <= PARAMETERS.keys()
    first, *_ = values = right(name)
    for value in values:
        file = given(name, value)
        scenario = parse_scenario(file)
        found = scenario.flat()[shown(name)]
        assert found == value and type(found) is type(value)
        if type(value) is float and value == first:
            # YAML 1.1 takes 1e-3 for a text, and 1 is a number, too
            for same in (str(value), int(value) if value.is_integer() else value):
                read = parse_scenario(file | {shown(name): same}).flat()[shown(name)]
                assert read == value and type(read) is float
        assert parse_scenario(written(scenario.to_dict())) == scenario
        assert parse_scenario(of_nodes(scenario)) == scenario


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_wrong_value_is_refused_by_name_value_and_range(name):
    for value in wrong(name):
        with pytest.raises(ScenarioError) as caught:
            parse_scenario({**BASE, shown(name): value})
        told = [text for text in caught.value.problems if text.startswith(f"{shown(name)} = ")]
        assert told and ": must be " in told[0], (value, caught.value.problems)


@pytest.mark.parametrize("text", ["0..1 s", ">= 0 N", "> 0 and <= 20 N", ">= 0 and < 1", "N", "-"])
def test_a_declared_range_is_what_messages_show(text):
    spec = parameter(0.5, text, "").metadata["spec"]
    assert spec.range_text().removeprefix("a number ") == ("a number" if text == "-" else text)
