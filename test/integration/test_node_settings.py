# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings that server and master make of their parameters."""

import contextlib
import re

import pytest
from rclpy.parameter import Parameter
from support.peers import ros
from support.processes import refused

from pmwvc_analysis import recorder_node
from pmwvc_bringup.session import plan
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, MasterParams
from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.runtime.process import refuse_undeclared
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_master import node as master
from pmwvc_master.settings import declare_settings as declare_master
from pmwvc_netem import node as netem
from pmwvc_server import node as server
from pmwvc_server.settings import declare_settings as declare_server

pytestmark = [pytest.mark.integration]

WRONG = {
    master: [
        ({"device.plugin": "glove"}, r"'glove': not installed; there are: .*simulated"),
        ({"device.mass": -1.0}, r"device.mass = -1.0: must be > 0 kg"),
        (
            {"master.velocity_filter.kind": "exact", "master.velocity_filter.share": 0.99},
            r"share = 0.99: no high-pass filter of order 2",
        ),
        ({"device.mas": 1.0}, r"device.mas: there is no such parameter; did you mean device.mass"),
        ({"side": 0}, r"side = 0: must be one of -1, 1"),
        ({"dof": 9}, r"dof = 9: must be 1..6"),
        ({"operator.kind": "playback_force", "operator.file": "/nowhere.csv"}, r"/nowhere.csv"),
    ],
    server: [
        ({"server.object_mass": -2.0}, r"server.object_mass = -2.0: must be 0.001..1000 kg"),
        (
            {"server.coupling": "explicit"},
            r"server.coupling = 'explicit': must be one of implicit",
        ),
        ({"users": ["user1", "user1"]}, r"users: 'user1' is there twice"),
        ({"user1.server.contact_stifness": 1.0}, r"did you mean user1.server.contact_stiffness"),
        ({"controller": "magic"}, r"controller = 'magic': must be one of pmwvc, direct"),
    ],
    netem: [
        ({"link.up.loss": 2.0}, r"^netem: link\.up\.loss = 2\.0: must be 0\.\.1$"),
        ({"link.up.los": 0.5}, r"^netem: link\.up\.los: .* did you mean link\.up\.loss\?$"),
        ({"preset": "wifi_god"}, r"^netem: preset = 'wifi_god': must be one of "),
        ({"users": ["a b"]}, r"^netem: users: 'a b' must be letters, digits and _, beginning"),
        ({"users": ["a", "a"]}, r"^netem: users: 'a' is there twice$"),
        ({"link_names": ["a"]}, r"^netem: link_names: there is no such parameter"),
        ({"link.up.jitter": "trace", "link.up.trace_file": "/no/such"}, r"/no/such: cannot be"),
    ],
    recorder_node: [
        ({"folder": ""}, "folder is empty"),
        ({"users": ["user 1"]}, "users: 'user 1' must be"),
        ({"reserve_mib": -1}, "reserve_mib = -1"),
        ({"folders": "x"}, "folders"),
    ],
}
# Masters are by name the first of a session, recorders have a folder.
USER = {master: ("-r", "__ns:=/user1")}
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


def declared(kind, given):
    """Declare the parameters of a server or of a master; nothing follows their changes."""
    if kind == "server":
        return declare_server(given, *[lambda *_: None] * 3)
    return declare_master(given, *[lambda _: None] * 2)


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


def planned(scenario, folder):
    """Return the parameters of the nodes that the session runner would start."""
    nodes = plan.nodes(scenario, folder=folder)
    found = {node.file_name: dict(node.parameters) for node in nodes}
    return {kind: given | {"start.paused": None} for kind, given in found.items()}


@pytest.fixture(scope="module")
def unequal(tmp_path_factory):
    """A scenario of unequal users, and its nodes."""
    scenario = parse_scenario(SCENARIO)
    return scenario, planned(scenario, tmp_path_factory.mktemp("session"))


@pytest.mark.parametrize("kind", ["server", "user1"])
def test_a_matrix_impedance_reaches_both_ends_and_a_wrong_one_is_refused(tmp_path, kind):
    scenario = parse_scenario(SCENARIO | {"master.impedance_matrix": "30 2; 2 20", "dof": 2})
    values = planned(scenario, tmp_path)[kind]
    with node(values) as given:
        settings = declared(kind, given)
        end = settings.users[0].server_impedance if kind == "server" else settings.impedance
        assert f"{end:.3f}" == f"{scenario.users[0].impedance:.3f}"
    with pytest.raises(ParameterError, match=r"master.impedance_matrix = .*must be 3 x 3"):
        with node(values | {"dof": 3}) as given:
            declared(kind, given)


def test_every_node_knows_its_users_as_the_scenario_does(unequal):
    scenario, parameters = unequal
    with node(parameters["server"]) as given:
        settings = declared("server", given)
        refuse_undeclared(given)
    assert (settings.server, settings.task) == (scenario.server, scenario.task)
    assert [user.server_impedance for user in settings.users] == [20.0, 30.0, 20.0]
    for user, wanted in zip(settings.users, scenario.users, strict=True):
        for name in ("name", "side", "contact", "baseline", "server_impedance"):
            assert getattr(user, name) == getattr(wanted, name)
        assert user.master.frame_s == wanted.master.frame_s
        with node(parameters[wanted.name]) as given:
            own = declared("master", given)
            refuse_undeclared(given)
        for name in ("master", "baseline", "contact", "device", "operator"):
            assert getattr(own, name) == getattr(wanted, name)
        setup = own.device_setup(None)
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
        anna, ben = declared("server", given).users
    assert anna.contact == ContactParams(contact_stiffness=700.0)
    assert ben.contact == ContactParams(contact_stiffness=900.0)
    assert (anna.server_impedance, ben.server_impedance) == (20.0, 40.0)
    assert (anna.side, ben.side) == (-1, 1)
    assert anna.master.rate_drop == MasterParams().rate_drop


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"user1.side": 0}, r"user1.side = 0: must be one of -1, 1"),
        ({"user2.server.contact_damping": -1.0}, r"user2.server.contact_damping = -1.0"),
        ({"user2.master.rate_drop": 0}, r"user2.master.rate_drop = 0"),
    ],
)
def test_a_wrong_value_is_named_with_its_user(values, text):
    with node(values) as given, pytest.raises(ParameterError, match=text):
        declared("server", given)


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [("server", "server.period_s", 0.02), ("user1", "master.rate_drop", 4)],
)
def test_rates_change_on_the_strict_channel_and_are_refused_on_the_plain_one(
    unequal, kind, name, value
):
    for channel, words in (("plain", "can change on the strict channel only"), ("strict", "")):
        with node(unequal[1][kind] | {"channel": channel}) as made:
            declared(kind, made)
            found = made.set_parameters_atomically([Parameter(name, value=value)])
            assert found.successful == (channel == "strict")
            assert words in found.reason


@pytest.mark.parametrize("kind", ["server", "user1"])
def test_a_deadband_needs_the_strict_channel_and_packets_before_the_silence(unequal, kind):
    name = "user1.server.deadband" if kind == "server" else "master.deadband"
    for given, words in (
        ({"channel": "plain"}, "needs channel = strict"),
        ({"channel": "strict", f"{name}.longest_s": 0.03}, "must be < safety.timeout_s = 0.03 s"),
    ):
        with node(unequal[1][kind] | given | {f"{name}.kind": "weber"}) as made:
            with pytest.raises(ParameterError, match=words):
                declared(kind, made)


@pytest.mark.parametrize(
    ("node", "values", "text"), [(node, *row) for node, rows in WRONG.items() for row in rows]
)
def test_a_wrong_setting_ends_a_node_with_one_clear_line_and_code_2(tmp_path, node, values, text):
    if node is recorder_node:
        values = {"folder": str(tmp_path / "a"), "users": ["user1"]} | values
    line = refused(node.main, values, arguments=USER.get(node, ()))
    assert re.search(text, line)
