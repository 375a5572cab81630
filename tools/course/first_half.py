# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps 1 to 5: direct coupling, waves, the price, aliasing, why passivity adds up."""

from collections.abc import Mapping

import numpy as np

from course.step import MJ, MM, PLAIN, Numbers, Question, Run, Session, Step
from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.charts.chart import DASHES, Chart, Curve, Panel
from pmwvc_analysis.charts.style import user_tint
from pmwvc_analysis.prediction.lag import lag_s

BLUE, ORANGE, GREEN, PURPLE = (user_tint(index) for index in range(4))
Sessions = Mapping[str, Session]


# 1: without waves


def _shaking_hz(session: Session) -> float:
    """Return the frequency at which the device shakes in the second half [Hz]."""
    user = session.user
    half = user.time_s > session.traces.duration_s / 2
    motion = user.xd_m[half, 0] - np.mean(user.xd_m[half, 0])
    spectrum = np.abs(np.fft.rfft(motion * np.hanning(len(motion))))
    spectrum[: int(1.0 * len(motion) * user.tick_s)] = 0.0  # below 1 Hz: the hand's own motion
    return float(np.argmax(spectrum) / (len(motion) * user.tick_s))


def _direct(found: Sessions) -> Numbers:
    near, far = found["near"], found["far"]
    user = far.user
    late = user.time_s > far.traces.duration_s - 2.0
    shaking_m = user.x_m[late, 0] - near.user.x_m[late, 0]  # without the carry, common to both
    return {
        "near_force": near.steady()["force"],
        "near_balance_mj": near.least_balance_mj(),
        "far_balance_mj": far.least_balance_mj(),
        "far_hz": _shaking_hz(far),
        "far_shaking_mm": float(np.ptp(shaking_m)) * MM,
        "far_peak": float(np.abs(user.f_applied).max()),
    }


def _direct_chart(found: Sessions) -> Chart:
    curves = [
        found["far"].curve("16 ms each way", "f_applied", ORANGE),
        found["near"].curve("no delay", "f_applied", BLUE, width=2.0),
    ]
    panel = Panel("force on the first device [N]", lines=curves)
    return Chart("direct", "Direct coupling with and without delay", "", [panel])


DIRECT = Step(
    "01_direct_coupling",
    "Direct coupling shakes",
    {"near": Run("direct_0ms"), "far": Run("direct_16ms")},
    _direct,
    _direct_chart,
)


# 2: waves


def _waves(found: Sessions) -> Numbers:
    session = found["waves"]
    energy = session.user.energy
    return {
        "force": session.steady()["force"],
        "balance_mj": session.least_balance_mj(),
        "sent_mj": float(energy["u_tx"][-1]) * MJ,
        "received_mj": float(energy["v_rx"][-1]) * MJ,
        "net_mj": float(energy["u_tx"][-1] - energy["v_rx"][-1]) * MJ,
    }


def _waves_chart(found: Sessions) -> Chart:
    forces = [
        found["direct"].curve("direct coupling", "f_applied", ORANGE),
        found["waves"].curve("waves", "f_applied", BLUE, width=2.0),
    ]
    (up, down) = (
        (balance.time_s, balance.balance_j * MJ)
        for user in user_energies(found["waves"].traces)[:1]
        for balance in (user.up, user.down)
        if balance is not None
    )
    sums = [
        Curve("to the server", *up, BLUE, width=2.0),
        Curve("back to the device", *down, GREEN, DASHES[1]),
    ]
    panels = [
        Panel("force on the first device [N]", lines=forces),
        Panel("energy kept by the link [mJ]", lines=sums, with_zero=True, height=120.0),
    ]
    return Chart("waves", "Waves over the links on which direct coupling shakes", "", panels)


WAVES = Step(
    "02_waves",
    "Waves do not shake",
    {"waves": Run("carry_16ms", PLAIN), "direct": Run("direct_16ms")},
    _waves,
    _waves_chart,
)


# 3: the price

DELAYS_MS = (0, 8, 16, 32)


def _price(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for delay in DELAYS_MS:
        session = found[f"d{delay}"]
        user, steady = session.scenario.users[0], session.steady()
        tau = lag_s(user, session.scenario, live=False)
        b = float(user.master.impedance)
        numbers |= {
            f"tau{delay}_ms": tau * 1e3,
            f"force{delay}": steady["force"],
            f"ahead{delay}_mm": steady["device"] - steady["avatar"],
            f"rule{delay}_mm": steady["force"] * tau / (2.0 * b) * MM,
            f"spring{delay}": 2.0 * b / tau,
            f"mass{delay}_kg": b * tau / 2.0,
        }
    return numbers


def _price_chart(found: Sessions) -> Chart:
    lines = []
    for index, delay in enumerate(DELAYS_MS):
        traces = found[f"d{delay}"].traces
        server = traces.server
        assert server is not None
        device = np.interp(server.time_s, traces.users[0].time_s, traces.users[0].x_m[:, 0])
        ahead = (device - server.x_s[0][:, 0]) * MM
        joined = server.time_s > 1.0
        label = f"{delay} ms each way"
        lines.append(Curve(label, server.time_s[joined], ahead[joined], user_tint(index)))
    panel = Panel("device ahead of its avatar [mm]", lines=lines, with_zero=True)
    return Chart("price", "The price of the delay", "", [panel])


PRICE = Step(
    "03_the_price",
    "The price: a spring and a mass",
    {f"d{delay}": Run("wall", {**PLAIN, "link.delay_s": delay / 1e3}, 6.0) for delay in DELAYS_MS},
    _price,
    _price_chart,
    {
        "transparency": Question(
            "transparency wall --set channel=plain",
            lambda said: {"felt_mass_kg": said["mass_felt"]},
        )
    },
)


# 4: aliasing

HUM_HZ = 122.0
HUM = {
    **PLAIN,
    "operator.kind": "sinusoid",
    "operator.force": 2.0,
    "operator.frequency_hz": HUM_HZ,
    "device.damping": 5.0,
    "server.gap_m": 0.05,
}


def _aliasing(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for name, session in found.items():
        user, server = session.user, session.traces.server
        assert server is not None
        late, late_steps = user.time_s > 1.0, server.time_s > 1.0
        numbers |= {
            f"{name}_balance_mj": session.least_balance_mj(),
            f"{name}_hum_um": _swing_m(user.x_m[late, 0], user.tick_s, HUM_HZ) * 1e6,
            f"{name}_device_mm": float(np.ptp(user.x_m[late, 0])) * MM,
            f"{name}_avatar_mm": float(np.ptp(server.x_s[0][late_steps, 0])) * MM,
        }
    return numbers


def _swing_m(position: np.ndarray, tick_s: float, hertz: float) -> float:
    """Return the swing of a motion at one frequency [m], peak to peak."""
    time_s = np.arange(len(position)) * tick_s
    turned = np.exp(-2j * np.pi * hertz * time_s) * np.hanning(len(position)) * 2.0
    centred = position - np.polyval(np.polyfit(time_s, position, 3), time_s)
    return float(4.0 * np.abs(np.mean(centred * turned)))


def _aliasing_chart(found: Sessions) -> Chart:
    lines = []
    for name, label, tint in (
        ("bare", "avatar, no filter", ORANGE),
        ("filtered", "avatar, with the filter", BLUE),
    ):
        server = found[name].traces.server
        assert server is not None
        joined = server.time_s > 0.2
        moved = (server.x_s[0][joined, 0] - server.x_s[0][joined, 0][0]) * MM
        lines.append(Curve(label, server.time_s[joined], moved, tint))
    panel = Panel("motion of the avatar [mm]", lines=lines)
    return Chart("aliasing", "A hum of 122 Hz, sampled 125 times a second", "", [panel])


ALIASING = Step(
    "04_aliasing",
    "Aliasing: a hum becomes a swing",
    {
        "bare": Run("wall", {**HUM, "master.filter.kind": "none"}, 4.0),
        "filtered": Run("wall", HUM, 4.0),
    },
    _aliasing,
    _aliasing_chart,
)


# 5: passivity adds up


def _adding(found: Sessions) -> Numbers:
    session = found["three"]
    found_budget = budget(session.traces, session.scenario)
    assert found_budget is not None
    table = found_budget.summary()
    devices = sum(
        user["device_kinetic_j"] + user["device_damping_j"] + user["sample_hold_j"]
        for user in table["users"]
    )
    channels = sum(float(user.joint.balance_j[-1]) for user in user_energies(session.traces))
    return {
        "hands_mj": table["hands_j"] * MJ,
        "channels_mj": channels * MJ,
        "devices_mj": devices * MJ,
        "server_mj": (table["hands_j"] - channels - devices) * MJ,
        "residual_uj": abs(table["residual_j"]) * 1e6,
        "balance_mj": session.least_balance_mj(),
    }


def _adding_chart(found: Sessions) -> Chart:
    lines = []
    for index, user in enumerate(user_energies(found["three"].traces)):
        kept = user.joint.balance_j * MJ
        lines.append(Curve(user.name, user.joint.time_s, kept, user_tint(index), DASHES[index]))
    total = np.sum([line.y for line in lines], axis=0)
    lines.append(Curve("all together", lines[0].x, total, "object", width=1.0))
    panel = Panel("energy kept by the channel [mJ]", lines=lines, with_zero=True)
    return Chart("adding", "Three channels and their sum", "", [panel])


ADDING = Step(
    "05_passivity_adds_up",
    "Why passivity adds up",
    {"three": Run("three_users", PLAIN)},
    _adding,
    _adding_chart,
)

STEPS = (DIRECT, WAVES, PRICE, ALIASING, ADDING)
