# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Explicit state: what the laws return is all they keep. A session that goes on from an earlier
state goes on bit for bit as it did before, whatever ran meanwhile.

Random controllers, filters, holds, port filters, couplings, contacts and axes run with packets
lost and late, and with silences. States are also taken on from a copy, under parameters that were
just made. The control is a law that changes what it is given.
"""

import pickle

from hypothesis import given, settings
from hypothesis import strategies as st
from support.played_laws import Laws

from pmwvc_core.law.channel import playout
from pmwvc_core.law.channel.pace import dropped
from pmwvc_core.scenario.reader import parse_scenario

FILTERS = [
    {"kind": "none"},
    {"kind": "first_order", "pole_rad_s": 50.0},
    {"kind": "butterworth", "pass_hz": 20.0, "stop_hz": 60.0},
    {"kind": "integrate_and_dump"},
]
AROUND = [
    {},
    {"velocity_filter": {"kind": "exact", "cutoff_hz": 30.0}},
    {"velocity_filter": {"kind": "complementary", "cutoff_hz": 30.0}},
    {"velocity_filter": {"kind": "equivalent", "cutoff_hz": 30.0}},
    {"bank": {"kind": "dissertation"}, "local_model": {"damping": 2.0}},
    {"bank": {"kind": "complementary"}, "local_model": {"acts": "above", "stiffness": 50.0}},
    {"position": {"feedback": "printed", "gain": 2.0}},
    {"position": {"feedback": "budgeted", "gain": 2.0, "storage_j": 0.02}},
    {"position": {"feedback": "integral", "gain": 2.0, "adapts": True}},
]
SERVERS = [
    *({"coupling": name} for name in ("implicit", "one_step_delay", "one_frame_late")),
    {"coupling": "unwrapped", "integrator": "trapezoid"},
    *(
        {"coupling": "unknown", "environment": environment, "decoding": decoding}
        | {"compensation": compensation}
        for environment, decoding, compensation in (
            ("cube", "secant", "ledger"),
            ("wall", "late", "corrected"),
            ("wall_with_slope", "late", "printed"),
            ("hunt_crossley", "late", "none"),
            ("active_wall", "secant", "ledger"),
        )
    ),
]
DEVICES = [{}, {"velocity": "euler", "encoder_step_m": 1e-5}, {"friction": 0.2}]
HANDS = ["hand", "sinusoid", "constant"]
CONTROLLERS = ["direct", "virtual_coupling", "tdpa", "pspm", *["pmwvc"] * 5]  # mostly waves


@st.composite
def scenarios(draw):
    """Draw one scenario."""
    controller = draw(st.sampled_from(CONTROLLERS))
    server = dict(draw(st.sampled_from(SERVERS if controller == "pmwvc" else [{}])))
    dof = draw(st.sampled_from([1, 2]))
    contact = draw(st.sampled_from(["grip", "bilateral"]))
    master = {
        "filter": draw(st.sampled_from(FILTERS)),
        "hold": draw(st.sampled_from(["zoh", "foh"])),
        "rate_drop": draw(st.sampled_from([1, 4, 8])),
        **draw(st.sampled_from(AROUND)),
    }
    if dof == 2 and controller == "pmwvc" and draw(st.booleans()):
        master["impedance_matrix"] = "30 5; 5 20"
    said = {
        "name": "drawn",
        "duration_s": 1.0,
        "controller": controller,
        "users": 2,
        "dof": dof,
        "channel": "plain",
        "master": master,
        "device": draw(st.sampled_from(DEVICES)),
        "operator": {"kind": draw(st.sampled_from(HANDS))},
        "server": {**server, "contact": contact, "period_s": draw(st.sampled_from([4e-3, 8e-3]))},
        "safety": {"soft_start_s": 0.05, "timeout_s": 0.05},
        "task": {"kind": "carry", "grip_s": 0.05, "move_s": 0.2},
    }
    if master.get("position", {}).get("feedback") != "printed":
        said["channel"] = draw(st.sampled_from(["plain", "strict", "zeroing"]))
        if said["channel"] == "zeroing":
            master["rate_drop"] = round(said["server"]["period_s"] / 1e-3)
    return parse_scenario(said)


@settings(max_examples=20)
@given(scenarios(), st.integers(0, 2**16), st.integers(60, 160), st.booleans())
def test_a_session_that_goes_on_from_a_state_goes_on_bit_for_bit(drawn, seed, until, unroll):
    """Nothing but numbers is in a state, and no law changes what it is given."""
    laws = Laws(drawn, seed, unroll=unroll)
    made, start, begun = repr(laws.made), laws.start, repr(laws.start)
    state, _ = laws.run(start, range(until))
    text, kept = repr(state), pickle.dumps(state)
    assert set(map(type, flat(state))) <= {float, int, bool}
    assert text != begun == repr(start)
    end, expected = laws.run(state, range(until, until + 60))
    assert repr(state) == text
    for others, start in (
        (laws, state),
        (laws, pickle.loads(kept)),
        (Laws(drawn, seed, unroll=not unroll), pickle.loads(kept)),  # just made
    ):
        again, found = others.run(start, range(until, until + 60))
        assert found == expected
        assert repr(again) == repr(end) != text
    assert repr(laws.made) == made


def flat(value):
    """What is in nested tuples, and in the lists of a playout."""
    if not isinstance(value, (tuple, list)):
        return [value]
    return [leaf for each in value for leaf in flat(each)]


def test_a_law_that_changes_what_it_is_given_is_noticed(monkeypatch):
    """The control."""
    said = {"name": "strict", "duration_s": 1.0, "controller": "pmwvc", "channel": "strict"}
    laws = Laws(parse_scenario(said | {"users": 2}), 1, unroll=False)
    state, _ = laws.run(laws.start, range(100))
    text = repr(state)

    def dropped_in_place(knots, count):
        knots[:] = dropped(knots, count)
        return knots

    laws.run(state, range(100, 160))
    assert repr(state) == text
    monkeypatch.setattr(playout, "dropped", dropped_in_place)
    laws.run(state, range(100, 160))
    assert repr(state) != text
