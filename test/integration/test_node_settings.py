# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings that server and master make of their parameters."""

import contextlib

import pytest
from rclpy.parameter import Parameter
from support.processes import ros

from pmwvc_bringup.session import plan
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, MasterParams
from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.runtime.process import refuse_undeclared
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_master.settings import declare_settings as declare_master
from pmwvc_server.settings import declare_settings

pytestmark = [pytest.mark.integration]

SCENARIO = {
    "name": "unequal",
    "duration_s": 1.0,
    "controller": "pmwvc",
    "channel": "plain",
    "users": 3,
    "master": {"impedance": 20.0},
    "server": {"contact_stiffness": 700.0, "gap_m": 0.01, "object_size_m": 0.08},
    "user2": {"master": {"impedance": 40.0, "rate_drop": 10}, "server": {"impedance": 30.0}},
    "user3": {"server": {"contact_stiffness": 900.0}, "side": -1},
    "baseline": {"tdpa": {"damping": 4.0}},
}


def declare_server(node):
    """Declare a server's parameters; nothing follows their changes."""
    return declare_settings(node, *[lambda *_: None] * 4)


@contextlib.contextmanager
def node(parameters):
    """A node that was given parameters, as the session runner writes them."""
    overrides = []
    for name, value in parameters.items():
        flat = values_of(name, value) if hasattr(value, "__dataclass_fields__") else {name: value}
        overrides += [Parameter(n, value=v) for n, v in flat.items() if v != [] and v is not None]
    options = {"automatically_declare_parameters_from_overrides": True}
    with ros(parameter_overrides=overrides, **options) as peer:
        yield peer.node


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """The nodes the session runner would start."""
    scenario = parse_scenario(SCENARIO)
    nodes = plan.nodes(scenario, folder=tmp_path_factory.mktemp("session"), paused=False)
    return scenario, {node.file_name: dict(node.parameters) for node in nodes}


@pytest.mark.parametrize("kind", ["server", "user1"])
def test_a_matrix_impedance_reaches_both_ends_and_a_wrong_one_is_refused(tmp_path, kind):
    matrix = {"master": {"impedance_matrix": "30 2; 2 20"}, "dof": 2}
    scenario = parse_scenario(SCENARIO | matrix)
    nodes = plan.nodes(scenario, folder=tmp_path, paused=False)
    given = dict(next(node.parameters for node in nodes if node.file_name == kind))
    given.pop("start.paused")
    with node(given) as parameters:
        if kind == "server":
            user = declare_server(parameters).users[0]
            assert f"{user.server_impedance:.3f}" == f"{scenario.users[0].impedance:.3f}"
        else:
            settings = declare_master(parameters, lambda _: None, lambda _: None)
            assert settings.master.impedance_matrix == "30 2; 2 20"
    where = "user1.master" if kind == "server" else "master"
    with (
        pytest.raises(ParameterError, match=rf"{where}.impedance_matrix = .*must be 3 x 3"),
        node(given | {"dof": 3}) as parameters,
    ):
        if kind == "server":
            declare_server(parameters)
        else:
            declare_master(parameters, lambda _: None, lambda _: None)


def test_the_server_knows_every_user_as_the_scenario_does(planned):
    scenario, parameters = planned
    parameters["server"].pop("start.paused")
    with node(parameters["server"]) as given:
        settings = declare_server(given)
        refuse_undeclared(given)
    assert settings.server == scenario.server
    assert settings.task == scenario.task
    for user, wanted in zip(settings.users, scenario.users, strict=True):
        assert user.name == wanted.name
        assert user.side == wanted.side
        assert user.contact == wanted.contact
        assert user.baseline == wanted.baseline
        assert user.server_impedance == wanted.server_impedance
        assert user.master.frame_s == wanted.master.frame_s
    assert [user.server_impedance for user in settings.users] == [20.0, 30.0, 20.0]


def test_a_master_knows_its_user_as_the_scenario_does(planned):
    scenario, parameters = planned
    for wanted in scenario.users:
        values = {k: v for k, v in parameters[wanted.name].items() if k != "start.paused"}
        with node(values) as given:
            settings = declare_master(given, lambda _: None, lambda _: None)
            refuse_undeclared(given)
        assert settings.master == wanted.master
        assert settings.baseline == wanted.baseline
        assert settings.contact == wanted.contact
        assert settings.device == wanted.device
        assert settings.operator == wanted.operator
        setup = settings.device_setup(None)
        assert setup.start_m == pytest.approx(wanted.side * (0.04 + 0.01))
        assert setup.half_width_m == pytest.approx(0.04)


def test_at_the_server_a_user_has_what_all_have_until_set_otherwise():
    values = {
        "users": ["anna", "ben"],
        "server.contact_stiffness": 700.0,
        "master.impedance": 20.0,
        "ben.server.contact_stiffness": 900.0,
        "ben.master.impedance": 40.0,
    }
    with node(values) as given:
        anna, ben = declare_server(given).users
    assert anna.contact == ContactParams(contact_stiffness=700.0)
    assert ben.contact == ContactParams(contact_stiffness=900.0)
    assert (anna.server_impedance, ben.server_impedance) == (20.0, 40.0)
    assert (anna.side, ben.side) == (-1, 1)
    assert anna.master.rate_drop == MasterParams().rate_drop


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"user1.side": 0}, r"user1.side = 0: must be -1 or 1"),
        ({"user2.server.contact_damping": -1.0}, r"user2.server.contact_damping = -1.0"),
        ({"user2.master.rate_drop": 0}, r"user2.master.rate_drop = 0"),
    ],
)
def test_a_wrong_value_is_named_with_its_user(values, text):
    with node(values) as given, pytest.raises(ParameterError, match=text):
        declare_server(given)


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [("server", "server.period_s", 0.02), ("user1", "master.rate_drop", 4)],
)
def test_rates_change_on_the_strict_channel_and_are_refused_on_the_plain_one(
    planned, kind, name, value
):
    declare = declare_server if kind == "server" else lambda n: declare_master(n, *[print] * 2)
    for channel, words in (("plain", "can change on the strict channel only"), ("strict", "")):
        with node(planned[1][kind] | {"channel": channel}) as made:
            declare(made)
            found = made.set_parameters_atomically([Parameter(name, value=value)])
            assert found.successful == (channel == "strict")
            assert words in found.reason


@pytest.mark.parametrize("kind", ["server", "user1"])
def test_a_deadband_needs_the_strict_channel_and_packets_before_the_silence(planned, kind):
    name = "user1.server.deadband" if kind == "server" else "master.deadband"
    declare = declare_server if kind == "server" else lambda n: declare_master(n, *[print] * 2)
    for given, words in (
        ({"channel": "plain"}, "needs channel = strict"),
        ({"channel": "strict", f"{name}.longest_s": 0.03}, "must be < safety.timeout_s = 0.03 s"),
    ):
        with node(planned[1][kind] | given | {f"{name}.kind": "weber"}) as made:
            with pytest.raises(ParameterError, match=words):
                declare(made)
