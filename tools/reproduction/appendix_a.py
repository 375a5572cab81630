# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. A: one user at a wall updated slowly."""

import numpy as np

from pmwvc_analysis.models.linearize import stable
from pmwvc_analysis.models.stability import crossings, radii
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from reproduction import draw_a, draw_single
from reproduction.channel_energy import aliasing_example
from reproduction.conditions import band_limited_balance, reflections
from reproduction.down_sampler import energy_over_cut_off, printed_scenario
from reproduction.figure import Figure, Values
from reproduction.scenarios import scenario, wall
from reproduction.single_user import admittance, contact, widths

CUT_OFF = "master.filter.stop_hz"


def cut_offs(parameters: Values) -> Values:
    """Return up to which cut-off the loop is stable, over M, for several stiffnesses."""
    low, high = parameters["cut_off_hz"]
    grid = np.geomspace(low, high, parameters["points"])
    data: Values = {"rate_drop": parameters["rate_drops"]}
    data["passive_hz"] = [500.0 / m for m in parameters["rate_drops"]]
    numbers: Values = {}
    for coupling in parameters["couplings"]:
        for stiffness in parameters["stiffnesses"]:
            row = []
            for m in parameters["rate_drops"]:
                values = {
                    **parameters["model"],
                    "server.coupling": coupling,
                    "server.contact_stiffness": stiffness,
                    "master.rate_drop": m,
                    "server.period_s": m * 1e-3,
                    CUT_OFF: float(grid[0]),
                }
                row.append(_first_loss(scenario(values, users=1), grid))
            data[f"{coupling}/{stiffness:g}"] = row
            for m, hertz in zip(parameters["rate_drops"], row, strict=True):
                numbers[f"{coupling}_k_{stiffness:g}_m_{m}"] = hertz
        rows = [data[f"{coupling}/{k:g}"] for k in parameters["stiffnesses"]]
        bound = data["passive_hz"]
        numbers[f"{coupling}_points_below_the_passive_bound"] = sum(
            hertz is not None and hertz < bound[place]
            for row in rows
            for place, hertz in enumerate(row)
        )
        numbers[f"{coupling}_points"] = sum(len(row) for row in rows)
    return {"data": data, "numbers": numbers}


def _first_loss(of: Scenario, grid: np.ndarray) -> float | None:
    """Return the lowest cut-off at which stability is lost, None where it is not."""
    if not stable(radii(of)[0]):
        return 0.0
    found = crossings(
        lambda values: stable(radii(*(varied(of, CUT_OFF, value) for value in values))),
        grid,
        within=1e-4,
    )
    return found[0][0] if found else None


def transmitted(parameters: Values) -> Values:
    """Return admittances, how they compare at high frequency, and the stiffness of the channel
    with other edges of the filter.
    """
    found = admittance(parameters)
    soft, stiff = (np.asarray(found["data"][f"b_{b}"]["high"]) for b in ("25", "80"))
    numbers = found["numbers"]
    numbers["high_b_80_over_25"] = float(np.exp(np.mean(np.log(stiff / soft))))
    numbers["high_share_b_80_stiffer"] = float(np.mean(stiff < soft))
    other = {**parameters["model"], **parameters["other_filter"]}
    numbers |= {
        f"other_filter_{name}": value
        for name, value in admittance({**parameters, "model": other, "impedances": [25.0]})[
            "numbers"
        ].items()
    }
    return found


def energies(parameters: Values) -> Values:
    """Return least and last energy the down-sampler keeps, over the cut-off."""
    filters = [
        FilterParams(kind="butterworth", pass_hz=low, stop_hz=high)
        for low, high in parameters["edges_hz"]
    ]
    found = energy_over_cut_off(printed_scenario(**parameters["model"]), filters)
    cut_off = [low for low, _ in parameters["edges_hz"]]
    data = {
        "cut_off_hz": cut_off,
        "minimum_j": found["minimum_j"],
        "final_j": found["final_j"],
        "finite": found["finite"],
    }
    numbers: Values = {}
    for place, hertz in enumerate(cut_off):
        numbers[f"minimum_{hertz:g}_hz_j"] = float(found["minimum_j"][place])
        numbers[f"final_{hertz:g}_hz_j"] = float(found["final_j"][place])
    for shift in (0, 1):
        example = aliasing_example(parameters["counterexample_edge_rad"], shift=shift)
        numbers[f"counterexample_left_shift_{shift}"] = example["left_j"] / example["in_j"]
    balance = band_limited_balance(parameters["band_limited_rate_drop"])
    numbers |= {f"band_limited_{name}": value for name, value in balance.items()}
    numbers |= {
        f"reflection_{name}": value
        for name, value in reflections(**parameters["reflections"]).items()
    }
    numbers["counterexample_printed"] = -(2.0 - np.pi / parameters["counterexample_edge_rad"])
    return {"data": data, "numbers": numbers}


TOUCH = wall(
    master__impedance=80.0,
    device__mass=0.05,
    device__damping=0.5,
    server__contact_stiffness=3500.0,
    server__contact_damping=25.0,
    server__coupling="one_step_delay",
    server__integrator="backward_euler",
)
PUSH = {"kind": "constant", "force": 1.0}
ALIASED = {**TOUCH, "master.filter.pass_hz": 250.0, "master.filter.stop_hz": 300.0}
DELAYED = {"server.coupling": "one_step_delay", "server.integrator": "backward_euler"}
TOUCH_REMARK = (
    "Simulated with one step of computational delay and backward Euler, m = 0.05 kg, "
    "b_hd = 0.5 Ns/m. "
)
FIGURES = (
    Figure(
        "A3",
        "Stability regions over rate drop and cut-off",
        "Cut-off: -20 dB of a first-order filter. Stable below the curves (first loss of "
        "stability); no curve: stable at every cut-off shown. The text excludes the computational "
        "delay, but only with it does stability fall with M as printed.",
        {
            "model": {
                key: value
                for key, value in wall(
                    master__filter__kind="first_order",
                    device__damping=0.0,
                    server__contact_damping=0.0,
                ).items()
                if not key.endswith("pass_hz")
            },
            "couplings": ["one_step_delay", "unwrapped"],
            "stiffnesses": [500.0, 1000.0, 2000.0, 3500.0, 5000.0],
            "rate_drops": list(range(1, 11)),
            "cut_off_hz": [2.0, 2000.0],
            "points": 61,
        },
        cut_offs,
        draw_a.cut_offs,
    ),
    Figure(
        "A4",
        "Transmitted admittance for several wave impedances",
        "Butterworth 25/50 Hz, trapezoid, loop solved; the packet carries the filter's output of "
        "the last tick.",
        {
            "model": wall(server__contact_stiffness=3500.0, server__contact_damping=25.0),
            "impedances": [25.0, 50.0, 80.0],
            "low_hz": [0.05, 5.0],
            "high_hz": [5.0, 50.0],
            "parts": ["low", "high"],
            "other_filter": {"master.filter.pass_hz": 50.0, "master.filter.stop_hz": 100.0},
        },
        transmitted,
        draw_single.admittance,
    ),
    Figure(
        "A5",
        "Z-width with waves and with direct coupling",
        "From the model, not measured: no friction, no quantisation. Waves with one step of "
        "computational delay; with the loop solved no limit is found below 1e6 N/m.",
        {
            "model": wall(),
            "damping": [0.0, 40.0, 81],
            "at_damping": 25.0,
            "curves": {
                "waves_b_80": {
                    "label": "multirate waves, b = 80 Ns/m",
                    "values": {**DELAYED, "master.impedance": 80.0},
                },
                "waves_b_25": {
                    "label": "multirate waves, b = 25 Ns/m",
                    "values": {**DELAYED, "master.impedance": 25.0},
                },
                "waves_solved": {
                    "label": "multirate waves, loop solved (no limit)",
                    "values": {"master.impedance": 80.0},
                },
                "direct": {
                    "label": "direct coupling",
                    "controller": "direct",
                    "values": {},
                },
            },
        },
        widths,
        draw_single.widths,
    ),
    Figure(
        "A6",
        "Contact with a wall of 3500 N/m, cut-off 25 Hz",
        TOUCH_REMARK,
        {"model": TOUCH, "operator": PUSH, "duration_s": 4.0, "every_ticks": 5},
        contact,
        draw_single.contact,
    ),
    Figure(
        "A7",
        "Contact with a wall of 3500 N/m, cut-off 250 Hz",
        TOUCH_REMARK + "The oscillation needs aliasing together with the computational delay: "
        "with the loop solved the same filter is stable. The wall pushes only, which bounds it; "
        "the limits of the device do not act. The filter is of order 8.",
        {"model": ALIASED, "operator": PUSH, "duration_s": 4.0, "every_ticks": 5},
        contact,
        draw_single.contact,
    ),
    Figure(
        "A8",
        "Energy kept by the down-sampler during a chirp of 0 to 10 Hz",
        "Simulated, chirp of 1 N, loop solved: the printed amplitude is not given. Butterworth "
        "filters of the least order of the sampled filter: 3, 4, 4, 6, 7, 8, 8.",
        {
            "model": {},
            "counterexample_edge_rad": 2.4,
            "band_limited_rate_drop": 20,
            "reflections": {
                "impedance": 25.0,
                "mass": 0.15,
                "stiffness": 2000.0,
                "period_s": 0.02,
            },
            "edges_hz": [
                [10.0, 25.0],
                [25.0, 50.0],
                [50.0, 100.0],
                [100.0, 150.0],
                [150.0, 200.0],
                [200.0, 250.0],
                [250.0, 300.0],
            ],
        },
        energies,
        draw_a.energies,
    ),
)
