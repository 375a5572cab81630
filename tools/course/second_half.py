# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps 6 to 10: late springs, loss, rendered stiffness, choosing b, what remains."""

from collections.abc import Mapping

import numpy as np

import pmwvc
from course.first_half import BLUE, GREEN, ORANGE, PURPLE
from course.step import MM, PLAIN, Numbers, Question, Run, Session, Step
from pmwvc_analysis.charts.chart import DASHES, Chart, Curve, Dots, Level, Panel
from pmwvc_analysis.prediction.lag import lag_s, series_stiffness
from pmwvc_analysis.transparency.transparency import transparency

Sessions = Mapping[str, Session]


# 6: late springs

STIFF = 2000.0
COUPLINGS = ("implicit", "one_step_delay", "one_frame_late")


def _late(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for name in COUPLINGS:
        session = found[name]
        late = session.user.time_s > session.traces.duration_s - 1.0
        if name == "one_step_delay":
            numbers[f"{name}_limit"] = pmwvc.stability(session.scenario)["k_max"]
        (server,) = [
            port["least_balance_j"]
            for port in session.summary["passivity"]["ports"]
            if port["owner"] == "server"
        ]
        numbers |= {
            f"{name}_given_j": -float(server),
            f"{name}_swing": float(np.ptp(session.user.f_applied[late, 0])),
            f"{name}_force": session.steady()["force"],
        }
    return numbers


def _late_chart(found: Sessions) -> Chart:
    curves = [
        found["one_frame_late"].curve("one frame late", "f_applied", ORANGE),
        found["one_step_delay"].curve("one step late", "f_applied", GREEN),
        found["implicit"].curve("solved together", "f_applied", BLUE, width=2.0),
    ]
    panel = Panel("force on the device [N]", lines=curves)
    return Chart("late", "A wall of 2000 N/m, computed on time and late", "", [panel])


LATE = Step(
    "06_late_springs",
    "Late springs give energy",
    {
        name: Run(
            "wall",
            {**PLAIN, "server.coupling": name, "server.contact_stiffness": STIFF},
            6.0,
        )
        for name in COUPLINGS
    },
    _late,
    _late_chart,
    {
        "stability": Question(
            "stability wall --set channel=plain --set server.coupling=one_frame_late",
            lambda said: {"one_frame_late_limit": said["k_max"]},
        )
    },
)


# 7: loss


def _loss(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    numbers["strict_balance_mj"] = found["strict"].least_balance_mj()
    for name in ("l0", "l10", "l40"):
        session = found[name]
        steady, links = session.steady(), session.summary["links"]
        numbers |= {
            f"{name}_sent": sum(link["sent"] for link in links),
            f"{name}_lost": sum(link["lost"] for link in links),
            f"{name}_force": steady["force"],
            f"{name}_ahead_mm": steady["device"] - steady["avatar"],
            f"{name}_balance_mj": session.least_balance_mj(),
        }
    return numbers


def _loss_chart(found: Sessions) -> Chart:
    lines = []
    shown = (
        ("l0", BLUE, "all arrive"),
        ("l10", GREEN, "10 % lost"),
        ("l40", ORANGE, "40 % lost"),
        ("strict", PURPLE, "40 % lost, strict"),
    )
    for name, tint, label in shown:
        session = found[name]
        server, user = session.traces.server, session.user
        assert server is not None, name
        joined = server.time_s > 1.0
        device = np.interp(server.time_s, user.time_s, user.x_m[:, 0])
        ahead = (device - server.x_s[0][:, 0])[joined] * MM
        lines.append(Curve(label, server.time_s[joined], ahead, tint))
    panel = Panel("first device ahead of its avatar [mm]", lines=lines, with_zero=True)
    return Chart("loss", "Lost packets", "", [panel])


LOSS = Step(
    "07_loss",
    "Loss costs position",
    {
        f"l{percent}": Run("carry_16ms", {**PLAIN, "link.loss": percent / 100}, 12.0)
        for percent in (0, 10, 40)
    }
    | {"strict": Run("carry_16ms", {"channel": "strict", "link.loss": 0.4}, 12.0)},
    _loss,
    _loss_chart,
)


# 8: rendered stiffness

WALLS = (200, 1000, 5000, 20000)


def _wall_mm(session: Session) -> float:
    """Return the position of the wall's face [mm]."""
    return -float(session.scenario.server.object_size_m) / 2.0 * MM


def _felt(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for stiffness in WALLS:
        session = found[f"k{stiffness}"]
        user, steady = session.scenario.users[0], session.steady()
        tau, b = lag_s(user, session.scenario, live=False), float(user.master.impedance)
        pressed_mm = steady["device"] - _wall_mm(session)
        numbers |= {
            f"rule{stiffness}": series_stiffness(stiffness, b, tau),
            f"pressed{stiffness}_mm": pressed_mm,
            f"felt{stiffness}": steady["force"] / pressed_mm * MM,
            "most": 2.0 * b / tau,
            "tau_ms": tau * 1e3,
        }
    return numbers


def _felt_chart(found: Sessions) -> Chart:
    numbers = _felt(found)
    k = np.geomspace(100.0, 30000.0, 60)
    session = found["k1000"]
    user = session.scenario.users[0]
    tau, b = lag_s(user, session.scenario, live=False), float(user.master.impedance)
    rule = np.array([series_stiffness(each, b, tau) for each in k])
    dots = np.array([numbers[f"felt{each}"] for each in WALLS])
    panel = Panel(
        "rendered stiffness [N/m]",
        lines=[
            Curve("1/(1/K + tau/2b)", k, rule, BLUE),
            Curve("K itself", k, k, "soft", DASHES[1]),
        ],
        dots=[Dots("measured in a press", np.array(WALLS, dtype=float), dots, ORANGE, "ring")],
        levels=[Level("2b/tau", numbers["most"], GREEN)],
        x_label="stiffness of the wall K [N/m]",
        x_log=True,
        y_range=(0.0, 2400.0),
    )
    return Chart("felt", "Stiffness of the wall and of what is felt", "", [panel])


FELT = Step(
    "08_felt_stiffness",
    "The stiffness that is felt",
    {f"k{each}": Run("wall", {**PLAIN, "server.contact_stiffness": each}, 6.0) for each in WALLS},
    _felt,
    _felt_chart,
)


# 9: choosing b

IMPEDANCES = (5, 10, 25, 50, 100)


def _choice(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for b in IMPEDANCES:
        session = found[f"b{b}"]
        rendered = transparency(session.scenario).rendered
        assert rendered.k_felt is not None and rendered.mass_felt is not None
        steady = session.steady()
        numbers |= {
            f"k{b}": rendered.k_felt,
            f"mass{b}_kg": rendered.mass_felt,
            f"pressed{b}": steady["force"] / (steady["device"] - _wall_mm(session)) * MM,
        }
    return numbers


def _choice_chart(found: Sessions) -> Chart:
    numbers = _choice(found)
    b = np.array(IMPEDANCES, dtype=float)
    stiffness = np.array([numbers[f"k{each}"] for each in IMPEDANCES])
    mass = np.array([numbers[f"mass{each}_kg"] for each in IMPEDANCES])
    pressed = np.array([numbers[f"pressed{each}"] for each in IMPEDANCES])
    above = Panel(
        "rendered stiffness [N/m]",
        lines=[Curve("exact model", b, stiffness, BLUE)],
        dots=[Dots("measured in a press", b, pressed, ORANGE, "ring")],
        x_label="wave impedance b [N s/m]",
        with_zero=True,
        height=140.0,
    )
    below = Panel(
        "rendered mass [kg]",
        lines=[Curve("exact model, free space", b, mass, PURPLE)],
        x_label="wave impedance b [N s/m]",
        with_zero=True,
        height=140.0,
    )
    return Chart("choice", "What b buys and what it costs", "", [above, below])


CHOICE = Step(
    "09_choosing_b",
    "Choosing b",
    {f"b{each}": Run("wall", {**PLAIN, "master.impedance": each}, 6.0) for each in IMPEDANCES},
    _choice,
    _choice_chart,
    {
        "tune": Question(
            "tune wall --set channel=plain",
            lambda said: {"proposed_b": said["best"]["settings"]["master.impedance"]},
        )
    },
)


# 10: what remains

COARSE = {**PLAIN, "device.encoder_step_m": 5e-5, "device.velocity": "euler"}


def _remains(found: Sessions) -> Numbers:
    numbers: Numbers = {}
    for name, session in found.items():
        numbers |= {
            f"{name}_balance_mj": session.least_balance_mj(),
            f"{name}_peak": session.summary["users"][0]["force_peak_n"],
            f"{name}_force": session.steady()["force"],
            f"{name}_ahead_mm": session.steady()["device"] - session.steady()["avatar"],
        }
    return numbers


def _remains_chart(found: Sessions) -> Chart:
    panels = [
        Panel(
            "force on the device [N]",
            lines=[
                found["coarse"].curve("encoder of 50 µm", "f_applied", ORANGE, width=1.0),
                found["exact"].curve("exact device", "f_applied", BLUE, width=2.0),
            ],
        ),
    ]
    return Chart("remains", "What a device measures decides, too", "", panels)


REMAINS = Step(
    "10_what_remains",
    "What remains",
    {
        "exact": Run("wall", PLAIN, 4.0),
        "coarse": Run("wall", COARSE, 4.0),
        "far": Run("wall", {**PLAIN, "link.delay_s": 0.1}, 8.0),
    },
    _remains,
    _remains_chart,
)

STEPS = (LATE, LOSS, FELT, CHOICE, REMAINS)
