# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every controller in a short live session of real nodes: what it books arrives in the recording,
its law holds there, and its parameters can be changed while it runs.

Two controllers without waves run at once.
"""

import contextlib
import json
import signal
from dataclasses import dataclass, field

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message
from support.excuses import unless_stalled
from support.peers import ros
from support.sessions import Running
from support.starts import not_heard
from support.verdicts import judged_passive, judged_stable, stood_still

from pmwvc_analysis.doctor import check_recording
from pmwvc_analysis.recording.reader import read_scenario, read_session

pytestmark = pytest.mark.integration
DURATION_S = 3.5
ROUNDING_J = 1e-9


@dataclass(frozen=True)
class Case:
    """A session, what its recording has to hold, and what is changed on the way; without a
    scenario one that also others look at.
    """

    scenario: str = ""
    settings: tuple[str, ...] = ()
    masters: tuple[set[str], ...] = (set(),)  # names of accounts, per user
    server: set[str] = field(default_factory=set)
    changes: dict[str, dict[str, float]] = field(default_factory=dict)  # by user


LOCAL = {"local_stored", "local_dissipated"}
BRANCHES = {"bank_low_in", "bank_low_out", "bank_high_in", "bank_high_out"}
POSITION = {"position_spent", "position_surplus", "position_discarded", "position_owed"}
PORT = {"environment", "late_decoding", "withheld", "contained", "tank", "granted", "capped"}
STRICT = {"node", *(f"playout_{name}" for name in ("given", "released", "discarded", "free"))}
BRAKES = {"avatar_brakes"}
TDPA, PSPM = {"tdpa_dissipated", "tdpa_allowance"}, {"pspm_tank", "pspm_spring"}
PLAIN = ("master.velocity_filter.kind=none", "device.velocity=exact", "device.encoder_step_m=0")
CASES = {
    "virtual_coupling": Case(),
    "tdpa": Case(masters=(TDPA,), server=TDPA),
    "pspm": Case(masters=(PSPM,), server=PSPM),
    # user1 with the velocity filter, user2 with bank and feedback, user3 with feedback later on
    "around the port": Case(
        "wall_filtered",
        (
            "users=3",
            *(f"{user}.{setting}" for user in ("user2", "user3") for setting in PLAIN),
            "user2.master.bank.kind=dissertation",
            "user2.master.local_model.damping=8",
            "user2.master.position.gain=20",
        ),
        ({"velocity_filter"}, BRANCHES | LOCAL | POSITION, POSITION),
        changes={
            "user2": {"master.local_model.stiffness": 800.0, "master.position.gain": 10.0},
            "user3": {"master.position.gain": 10.0},
        },
    ),
    # strict: plain is passive over a constant delay only, and a machine that stalls makes it vary
    "unknown environment on three axes": Case(
        "cube_3d",
        ("server.coupling=unknown", "server.environment=wall", "server.period_s=0.02"),
        (STRICT, STRICT),
        PORT | BRAKES,
    ),
}


def passive(ended):
    """No balance is below zero."""
    judged_passive(ended)


def users_are_passive(ended):
    """No balance of any user is below zero."""
    judged_passive(ended, only_users=True)


def coupled_by_a_spring(ended):
    """At rest the hand feels the coupling's spring, stretched from avatar to device."""
    (user,) = ended.summary()["users"]
    stiffness = read_scenario(ended.folder).users[0].baseline.virtual_coupling.stiffness
    with unless_stalled(lambda: stood_still(ended)):  # the hand may be moving at the end
        assert user["force_final_n"] == pytest.approx(stiffness * user["drift_m"], rel=0.05)


def avatar_owes_nothing(ended):
    """The avatar's end of time-domain passivity control gives out what it may, no more."""
    assert ended.traces.server.accounts["tdpa_allowance"].min() >= -ROUNDING_J


def each_part_pays(ended):
    """The surplus of position feedback is never below zero; what the waves of the local model
    bring is in its spring or in its heat, also across a change of the spring.

    No promise for user2: the dissertation's bank may give out energy where it joins its branches.
    """
    filtered, with_bank, later = ended.traces.users
    passives = {user["name"]: user["passive"] for user in ended.summary()["users"]}
    with unless_stalled(lambda: stood_still(ended)):  # plain is passive over a constant delay
        assert passives[filtered.name] and passives[later.name], ended.summary()["passivity"]
    for user in (with_bank, later):
        surplus = user.accounts["position_surplus"]
        assert surplus.min() >= -ROUNDING_J
        assert surplus.max() > 1e-6
    spent = later.accounts["position_spent"]
    moves = np.ptp(later.x_m[later.time_s < later.block_time_s[np.flatnonzero(spent)[0]]])
    assert moves > 1e-4  # it moved already when the feedback was switched on
    accounts = with_bank.accounts
    brought = accounts["bank_high_in"] - accounts["bank_high_out"]
    kept = accounts["local_stored"] + accounts["local_dissipated"]
    assert np.abs(brought - kept).max() <= ROUNDING_J
    assert brought[-1] > 100.0 * ROUNDING_J


def gives_no_more_than_it_got(ended):
    """The joint ledger of an unknown environment keeps the port passive."""
    passive(ended)
    accounts = ended.traces.server.accounts
    given = accounts["environment"] + accounts["late_decoding"] + accounts["withheld"]
    assert given.min() >= -ROUNDING_J
    assert accounts["late_decoding"].min() < 0.0  # there was something to withhold from


LAWS = {
    "virtual_coupling": coupled_by_a_spring,
    "tdpa": avatar_owes_nothing,
    "pspm": users_are_passive,
    "around the port": each_part_pays,
    "unknown environment on three axes": gives_no_more_than_it_got,
}


@pytest.fixture(scope="module", params=CASES)
def ended(request, tmp_path_factory):
    """A session that has ended, with its case and its traces."""
    name, case = request.param, CASES[request.param]
    with contextlib.ExitStack() as stack:
        if case.scenario:
            folder = tmp_path_factory.mktemp("controller") / "session"
            words = [word for setting in case.settings for word in ("--set", setting)]
            duration = ("--duration", 600 if case.changes else DURATION_S)
            session = stack.enter_context(Running(folder, case.scenario, *duration, *words))
            session.refused = change(session, case.changes) if case.changes else []
            session.code, session.left = session.end(), session.nodes()
        elif name == "tdpa":
            session = request.getfixturevalue("given_damping")
        else:
            session = request.getfixturevalue("pair")[name]
        session.case, session.name = case, name
        session.traces = read_session(session.folder)
        yield session


def change(session, values):
    """Set parameters of masters once all runs, and end the session some ticks later; return why
    any was refused.
    """
    with ros(domain=session.domain()) as peer:
        session.await_ticks()
        reasons = [peer.set_parameters(f"/{user}/master", new) for user, new in values.items()]
        for _ in range(2):
            session.await_ticks()
        session.process.send_signal(signal.SIGINT)
        return [text for texts in reasons for text in texts if text]


def statuses(folder):
    """Return every status in the recording."""
    (path,) = folder.glob("*.mcap")
    with path.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages("/diagnostics"):
            yield from deserialize_message(message.data, DiagnosticArray).status


def test_a_session_runs_from_first_tick_to_last_without_an_error(ended):
    assert ended.code == 0, ended.output()
    assert getattr(ended, "refused", []) == []
    assert ended.events() == []
    assert ended.left == {}
    judged_stable(ended)
    for user in ended.traces.users:
        assert user.tick[0] == 0
        assert len(user.tick) + user.missed == user.tick[-1] + 1  # a busy machine may skip
        assert user.tick[-1] > 0.9 * DURATION_S / user.tick_s
    assert set(ended.summary()["recording"]["missing"].values()) == {0}
    seen = list(statuses(ended.folder))
    assert {status.name for status in seen} >= {"/server", "/user1/master"}
    errors = [status for status in seen if status.level == DiagnosticStatus.ERROR]
    assert errors == []
    assert not_heard(ended.traces) == set()


def test_what_a_controller_books_arrives_by_name(ended):
    assert [set(user.accounts) for user in ended.traces.users] == list(ended.case.masters)
    assert set(ended.traces.server.accounts) == ended.case.server
    for owner in (*ended.traces.users, ended.traces.server):
        for name, values in owner.accounts.items():
            assert np.isfinite(values).all(), name


def test_the_energy_budget_closes(ended):
    found = json.loads((ended.folder / "budget.json").read_text("utf-8"))
    assert found["closes"], found


def test_the_numbers_of_the_recording_fit_each_other(ended):
    troubles = [found for found in check_recording(ended.folder) if found.status != "ok"]
    assert troubles == []


def test_a_session_keeps_the_law_of_its_controller(ended):
    assert set(LAWS) == set(CASES)
    LAWS[ended.name](ended)


def test_no_force_jumps_further_than_the_limit_of_its_slope(ended):
    for user, known in zip(ended.traces.users, read_scenario(ended.folder).users, strict=True):
        steps = np.linalg.norm(np.diff(user.f_applied, axis=0), axis=-1)
        assert steps.max() <= known.safety.max_slew * user.tick_s * (1.0 + 1e-9)
        assert np.abs(user.f_applied).max() > 0.1  # there was something to feel
