# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Key numbers of the redrawn figures, from results computed here; committed files match the code.

Files are only asked what they were made with: what they say must have come from these parameters.
"""

import functools
import json
from pathlib import Path

import pytest
from support.plain import load

from reproduction import pages
from reproduction.claim import Claim, verdict
from reproduction.compensation import largest_stiffness
from reproduction.files import read
from reproduction.position_drift import HANDS, LINKS, MODEL
from reproduction.registry import FIGURES
from reproduction.scenarios import scenario
from reproduction.simulated_width import simulated_z_width

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "reproduction"
LARGEST_PICTURE = 170_000


@functools.cache
def of_the_figure(name):
    return FIGURES[name].compute(FIGURES[name].parameters)["numbers"]


def numbers(name, **changed):
    figure = FIGURES[name]
    if not changed:
        return of_the_figure(name)
    return figure.compute({**figure.parameters, **changed})["numbers"]


def test_direct_coupling_of_app_b_fig_3():
    """The table behind Fig. 2: ``test_stability_model.py``."""
    found = numbers("B3", points=2)
    for delay, expected in enumerate((2500.0, 335.3, 47.1, 0.0)):
        assert found[f"k_max_delay_{delay}"] == pytest.approx(expected, rel=5e-3)


def test_the_offsets_of_app_b_fig_5():
    found = numbers("B5", duration_s=8.0)
    for delay, expected in ((0, 0.55), (2, 1.19), (3, 1.51)):
        assert found[f"ahead_delay_{delay}_mm"] == pytest.approx(expected, rel=5e-3)
        assert found[f"force_delay_{delay}_n"] == pytest.approx(1.0, rel=1e-4)
        assert found[f"pressed_delay_{delay}_mm"] == pytest.approx(2.0, rel=1e-4)


def test_peaks_and_rendered_stiffness_of_app_a_fig_4():
    # the output of the last tick is sent: 1 ms more lag than in the known 939.4 and 1889.2 N/m
    found = numbers("A4")
    for b, stiffness, peak in ((25, 939.4, 7.47), (80, 1889.2, 5.97)):
        felt = 1.0 / (1.0 / stiffness + 1e-3 / (2.0 * b))
        assert found[f"k_felt_b_{b}"] == pytest.approx(felt, rel=1e-3)
        assert found[f"first_peak_hz_b_{b}"] == pytest.approx(peak, rel=0.02)
    assert found["first_peak_hz_ideal"] == pytest.approx(15.87, rel=2e-3)


def test_aliasing_destabilises_only_together_with_the_computational_delay():
    calm, aliased = numbers("A6"), numbers("A7")
    assert calm["spectral_radius"] < 1.0 < aliased["spectral_radius"]
    assert aliased["spectral_radius_loop_solved"] < 1.0
    assert calm["force_swing_n"] < 0.01 < 1.0 < aliased["force_swing_n"]


@pytest.mark.parametrize("name", FIGURES)
def test_a_committed_file_was_made_with_the_parameters_of_the_code(name):
    written = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    figure = FIGURES[name]
    assert written["parameters"] == json.loads(json.dumps(figure.parameters)), "run make figures"
    assert (written["title"], written["remark"]) == (figure.title, figure.remark)
    assert (FOLDER / f"{name}.svg").stat().st_size < LARGEST_PICTURE


def test_the_pages_are_written_from_the_committed_results():
    known = pages.known_numbers(FOLDER)
    assert (FOLDER / "claims.md").read_text("utf-8") == pages.claims_page(known), "make figures"
    index = (FOLDER / "README.md").read_text("utf-8")
    assert index == pages.index_page(), "make figures"
    assert all(f"]({name}.svg)" in index for name in FIGURES)
    drift = (FOLDER / "position_drift.md").read_text("utf-8")
    assert drift == pages.drift_page(FOLDER), "make figures"


def test_the_page_on_drift_is_of_carry_16ms_and_over_a_minute_its_numbers_are_the_same():
    given = load("carry_16ms").flat()
    assert {name: given[f"operator.{name}"] for name in HANDS} == HANDS
    assert given["safety.max_force"] == MODEL["safety.max_force"]
    assert given["link.up.delay_s"] == given["link.down.delay_s"] == MODEL["link.delay_s"]
    assert (given["task.kind"], given["users"]) == ("carry", 2)
    found = read("position_drift", FOLDER)["numbers"]
    for link in LINKS:
        assert found[f"least_balance_mj_{link}_printed"] < -1.0
        for paid in ("budgeted", "integral"):
            assert found[f"least_balance_mj_{link}_{paid}"] >= -1e-3


@pytest.mark.parametrize(
    ("bounds", "value", "expected"),
    [
        ({"printed": 100.0}, 104.0, "reproduced (+4.0%)"),
        ({"printed": 100.0}, 106.0, "differs by +6.0%"),
        ({"printed": 0.0}, 47.0, "differs by 47"),
        ({"at_least": 4.0}, 3.0, "differs by -1"),
        ({"at_least": 4.0}, 4.5, "reproduced"),
        ({"at_most": 1.0}, 2.0, "differs by 1"),
    ],
)
def test_verdicts(bounds, value, expected):
    assert verdict(Claim("", "", "", **bounds), value) == expected


@pytest.mark.parametrize(
    ("damping", "factor", "softest", "step"),
    [(0.0, 1.58, 600.0, 100.0), (15.0, 1.78, 1600.0, 200.0)],
)
def test_compensation_raises_the_stiffness_by_half_and_more(damping, factor, softest, step):
    """App. C section 6, "almost twice"; the form that lengthens waves gave 0.28 to 0.44."""
    parameters = FIGURES["C5"].parameters["stiffness"]
    _, stiffest, _ = parameters["grid"]
    parameters = parameters | {"damping": [damping], "grid": [softest, stiffest, step]}
    found = largest_stiffness(parameters)
    assert found[f"factor_at_{damping:g}"] == pytest.approx(factor, abs=0.15)


def test_the_contact_of_app_c_under_every_compensation():
    found = numbers("C5", stiffness={**FIGURES["C5"].parameters["stiffness"], "damping": []})
    assert found["made_by_delay_none_mj"] < -0.1
    assert found["lowest_after_printed_mj"] < -0.5  # the control: as printed it makes energy
    for kind in ("corrected", "ledger"):
        assert found[f"lowest_after_{kind}_mj"] >= -1e-9
    # What is above it is the credit of falling forces, which is kept.
    assert found["apart_from_environment_corrected"] < 0.06
    assert found["force_end_n"] == pytest.approx(found["contact_force_end_n"], rel=1e-3)


def test_the_z_width_of_app_c_with_a_ledger_is_that_without():
    curves, model = (FIGURES["C4"].parameters[name] for name in ("curves", "model"))
    limit = numbers("C4", damping=[0.0, 0.0, 1], curves={"waves": curves["waves"]})["at_0_waves"]
    assert limit == pytest.approx(1394.4, rel=1e-3)
    ledger = scenario({**model, **curves["ledger"]["values"]}, users=1)
    below, above = 0.98 * limit, 1.02 * limit
    assert simulated_z_width(ledger, 0.0, highest=below, parts=1, rounds=1) == (below, None)
    assert simulated_z_width(ledger, 0.0, highest=above, parts=1, rounds=1) == (0.0, above)


def test_the_experiments_of_app_d_with_right_and_wrong_filter():
    plain, wrong, right = numbers("D8"), numbers("D9"), numbers("D10")
    assert plain["spectral_radius"] < 1.0 and right["spectral_radius"] < 1.0
    assert wrong["spectral_radius"] > 1.05
    assert plain["force_noise_n"] ** 2 > 10.0 * right["force_noise_n"] ** 2
    assert plain["limited_ticks"] == right["limited_ticks"] == 0
    assert wrong["force_largest_n"] == pytest.approx(20.0)  # diverges up to the safety limit
    assert right["spectral_radius_delay_20_ms"] < 1.0
    assert right["spectral_radius_delay_100_ms"] < 1.0


def test_the_largest_stiffness_of_app_a_fig_5_is_searched_between_the_points_of_the_grid():
    """Of direct coupling the points alone give 900 and 1,300 N/m, a finer grid 1601.2."""
    curves = FIGURES["A5"].parameters["curves"]
    coarse, waves = (
        numbers("A5", damping=grid, curves={name: curves[name]})[f"largest_{name}"]
        for name, grid in (
            ("direct", (0.0, 16.0, 3)),
            ("waves_b_80", (9.5, 9.5, 1)),  # the top of a flat curve
        )
    )
    assert coarse == pytest.approx(1601.197, rel=2e-3)
    assert 2.8 < waves / coarse < 2.87


def test_the_regions_of_app_c_that_end_are_not_clipped_and_one_has_no_end():
    found = numbers("C3", points=100)
    tall = "_window_four_times_as_high"
    open_ended = "area_printed_sigma_0_unwrapped"
    assert found[open_ended + tall] > 2.0 * found[open_ended]
    for name in ("printed_sigma_0_one_step_delay", "loop_sigma_0.2_unwrapped"):
        area = found[f"area_{name}"]
        assert found[f"area_{name}{tall}"] == pytest.approx(area, rel=0.02)


def test_what_the_filter_bank_of_app_e_does_to_passivity():
    found = numbers("E5", local_stiffness=[500.0, 500.0, 1], gains=[0.0, 20.0])
    assert found["bank_table"] == pytest.approx(1.0, abs=1e-9)
    assert found["bank_lower"] == pytest.approx(1.90, abs=0.01)
    assert found["bank_switching_table"] == pytest.approx(2.0**0.5, rel=1e-3)
    improved = found["least_gain_20"] - found["plain"]
    assert abs(found["least_gain_0"] - found["plain"]) < 0.05 * improved


def test_the_local_model_of_app_e():
    found = numbers("E6")
    assert found["k_felt_waves"] == pytest.approx(357.3, rel=1e-3)
    for name in ("table", "bank"):
        assert found[f"k_felt_{name}"] == pytest.approx(
            500.0, rel=1e-4
        )  # by K_p, not by the model
    peaks = [found[f"first_peak_hz_{name}"] for name in ("waves", "table", "bank", "ideal")]
    assert peaks == sorted(peaks)
    assert peaks[1] < 1.03 * peaks[0] and peaks[2] > 1.25 * peaks[0]


def test_the_stability_of_app_e_with_a_local_model():
    found = numbers("E5", local_stiffness=[0.0, 1000.0, 2], gains=[0.0, 20.0])
    assert found["least_gain_0"] == pytest.approx(found["plain"], rel=1e-3)
    assert found["least_gain_20"] > 1.03 * found["plain"]
    assert found["spectral_radius_damping_1"] > 1.5
    assert found["spectral_radius_damping_3"] < 1.0
