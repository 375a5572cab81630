# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An avatar that joined at the face of an object, its device inside, comes to the device where it
touches nothing; its port gives out no energy for that, and no wave or force changes.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Users
from support.laws import alter_laws

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.events.nodes import of_server
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_bringup import scenarios as files
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.law.server import server_port
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.simulation.session import SteppedSession
from pmwvc_core.transport.packet import WavePacket

B, H, SIZE_M = 25.0, 0.008, 0.06
ROUNDING = 1e-12


def make(*, environment="wall", users=1, dof=1, gap_m=0.0, coupling="implicit"):
    params = ServerParams(environment=environment, coupling=coupling, object_size_m=SIZE_M)
    contacts = [ContactParams(contact="grip", gap_m=gap_m)] * users
    return Users(params, contacts, b=B, axes=dof)


def wave_of(speed):
    """Wave that moves a free avatar with a speed [m/s]."""
    return speed * np.sqrt(B / 2.0)


def as_signal(array):
    return float(array[0]) if array.shape == (1,) else array


sessions = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "environment": st.sampled_from(("wall", "cube")),
        "dof": st.integers(1, 3),
        "gap_m": st.sampled_from((0.0, 0.005)),
        "speed": st.sampled_from((0.02, 0.2, 1.0)),
        "stays": st.lists(st.integers(1, 60), min_size=1, max_size=4),
    }
)


@settings(max_examples=20)
@given(session=sessions)
def test_no_port_gives_out_energy_where_avatars_slide_and_users_come_and_go(session):
    rng = np.random.default_rng(session["seed"])
    users, dof = 1 if session["environment"] == "wall" else 2, session["dof"]
    names = ("environment", "dof", "gap_m")
    server = make(users=users, **{name: session[name] for name in names})
    moved = balance = 0.0
    for steps in session["stays"]:  # each begins with a gap, or with another life of the master
        for i in range(users):
            server.join(i, as_signal(rng.normal(0.0, 0.03, dof)))
        waves = [rng.normal(size=dof) for _ in range(users)]
        for _ in range(steps):
            before = [np.abs(each) for each in server.offset]
            waves = [0.95 * wave + 0.3 * rng.normal(size=dof) for wave in waves]
            sent = [as_signal(wave_of(session["speed"]) * wave) for wave in waves]
            for u, v in zip(sent, server.step(sent), strict=True):
                moved += 0.5 * H * np.sum(np.square(u) + np.square(v))
                balance += 0.5 * H * np.sum(np.square(u) - np.square(v))
            assert balance >= -ROUNDING * moved
            assert abs(server.stored + server.dissipated - balance) <= 1e-11 * moved
            for offset, was in zip(server.offset, before, strict=True):
                assert np.all(np.abs(offset) <= was)
                assert np.all(was - np.abs(offset) <= server_port.SLIDE_M_S * H + 1e-15)


@pytest.mark.parametrize("coupling", ["implicit", "one_step_delay", "one_frame_late", "unwrapped"])
def test_waves_forces_and_velocities_are_those_of_an_avatar_that_stays(coupling, monkeypatch):
    rng = np.random.default_rng(5)
    server = make(coupling=coupling)
    server.join(0, -0.01)
    slid = 0.0
    for step in range(200):
        u = wave_of(-0.05 + 0.1 * rng.normal()) if step < 100 else wave_of(0.1 * rng.normal())
        state, offset, found = server.s, server.offset[0], []
        for speed in (0.0, server_port.SLIDE_M_S):
            server.s = state
            with monkeypatch.context() as sliding:
                sliding.setattr(server_port, "SLIDE_M_S", speed)
                server.step([u])
            (port,) = server.s.ports
            found.append((port.v_s, server.f_s, server.xd_s, server.energies, port.u_j, port.v_j))
        assert found[0] == found[1]
        slid += server.offset[0] - offset
    assert slid == pytest.approx(0.02)
    assert server.offset[0] == 0.0


def test_sliding_in_contact_gives_energy_out(monkeypatch):
    """The control."""
    monkeypatch.setattr(server_port, "cleared", lambda contact, way: way)
    server = make()
    server.join(0, -0.01)
    for _ in range(200):
        server.step([0.0])
    assert server.taken_j < -1e-3


def test_the_avatar_stays_the_gap_outside_the_face_and_slides_when_there_is_room():
    server = make(gap_m=0.005)
    server.join(0, -0.02)
    for _ in range(200):
        server.step([0.0])
    assert server.x_s[0] == pytest.approx(-0.035, abs=1e-15)
    assert server.offset[0] == pytest.approx(-0.015)
    for _ in range(200):
        server.step([wave_of(-0.01)])  # 16 mm outwards
        assert server.x_s[0] <= -0.035 + 1e-9
    assert server.offset[0] == 0.0
    assert server.x_s[0] == pytest.approx(-0.036)


def test_a_device_is_sent_the_position_of_its_avatar_without_what_it_has_slid():
    end = ServerEnd(files.load("wall", settings_texts=["server.gap_m=0"]))
    wave, energy, moved = wave_of(-0.05), 0.0, 0.0
    for number in range(1, 101):
        now_ns, energy = number * 8_000_000, energy + 0.5 * H * wave**2
        packet = WavePacket(1, number, now_ns, H, wave, number * H * wave, energy, -0.01)
        (answer,), row = end.tick(now_ns, [[packet]])
        moved += H * row.xd_s[0]
        assert answer.position == pytest.approx(-0.01 + moved, abs=1e-12)
    assert end.s.environment.ports[0].offset[0] == 0.0


TIMES_S = [0.0, 0.2, 0.5, 1.6, 2.0, 2.6, 3.0, 4.4]
PLACES_M = [0.0, 0.0, 0.016, 0.016, -0.02, -0.02, 0.016, 0.016]
OUTAGE_S, INSIDE_S, FREE_S, END_S = 1.0, 1.6, 2.6, 4.4
ROUND_TRIP_S = 0.016 + 0.016 + 0.008 + 0.0035  # link both ways, one step of the server, ramp


def rejoined(folder, duration_s=END_S):
    """A hand presses, is taken out in an outage, joins again inside, backs off, presses again."""
    times = np.arange(0.0, END_S + 0.01, 0.02)
    rows = [f"{t:.2f},{np.interp(t, TIMES_S, PLACES_M):.6f}" for t in times]
    file = folder / "motion.csv"
    file.write_text("\n".join(["time_s,x_m", *rows]), "utf-8")
    texts = [
        "task.kind=free",
        "operator.kind=playback_motion",
        f"operator.file={file}",
        "operator.time_column=time_s",
        "operator.columns=x_m",
        "link.delay_s=0.016",
        "safety.release_s=0.3",
        f"link.schedule={OUTAGE_S} outage; {OUTAGE_S + 0.4} base",
    ]
    scenario = files.load("wall", settings_texts=texts, duration_s=duration_s)
    batch = SteppedSession(scenario)
    batch.run(lambda _: None)
    return scenario, batch.traces()


def apart_m(traces, at_s):
    user, server = traces.users[0], traces.server
    x_m = np.interp(at_s, user.time_s, user.x_m[:, 0])
    return x_m - np.interp(at_s, server.time_s, server.x_s[0][:, 0])


def test_a_hand_that_joined_again_inside_is_with_its_avatar_after_backing_off(tmp_path):
    scenario, traces = rejoined(tmp_path)
    user, server = traces.users[0], traces.server
    first_s, again_s = (
        e["time_s"] for e in of_server(server, traces, None) if e["kind"] == "join"
    )
    assert abs(apart_m(traces, first_s)) < 1e-3 and 0.01 < apart_m(traces, again_s) < 0.02
    assert (server.state[0][server.time_s > OUTAGE_S] == 0).any()  # it was taken out
    assert apart_m(traces, INSIDE_S) > 0.01  # still inside
    assert abs(apart_m(traces, FREE_S)) < 5e-4
    force = user.f_applied[-1, 0]
    spring_m = force * ROUND_TRIP_S / (2.0 * B)  # the link's own, theory 11
    assert force > 2.0
    assert apart_m(traces, END_S) == pytest.approx(spring_m, rel=0.05)
    limit = scenario.users[0].safety.max_slew * scenario.tick_s
    assert np.abs(np.diff(user.f_applied[:, 0])).max() <= limit * (1.0 + 1e-9)
    (entry,) = user_energies(traces, scenario)
    for way in (entry.up, entry.down, entry.joint):
        assert way.minimum_j >= -ROUNDING
    assert inconsistencies(traces, scenario) == []
    found = apart(traces, user)
    inside = found.kept[(found.time_s > OUTAGE_S + 0.5) & (found.time_s < INSIDE_S)]
    assert inside.min() > 0.01  # while the device is inside
    assert found.kept[-1] == pytest.approx(0.0, abs=1e-12)
    assert found.error[-1, 0] == pytest.approx(spring_m, rel=0.05)


def test_without_sliding_it_is_apart_for_good(tmp_path, monkeypatch):
    """The control."""
    alter_laws(monkeypatch, server__server_port__SLIDE_M_S=0.0)
    _, traces = rejoined(tmp_path, FREE_S)
    assert apart_m(traces, FREE_S) > 0.01
