# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Key numbers of the redrawn figures, from results computed here; committed files match the code.

Files are only asked what they were made with: what they say must have come from these parameters.
"""

import json
from pathlib import Path

import pytest

from pmwvc_analysis.reproduction import pages
from pmwvc_analysis.reproduction.claim import Claim, verdict
from pmwvc_analysis.reproduction.registry import FIGURES

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "reproduction"
LARGEST_PICTURE = 150_000


def numbers(name, **changed):
    figure = FIGURES[name]
    return figure.compute({**figure.parameters, **changed})["numbers"]


def test_the_stiffness_table_behind_fig_2_of_app_b():
    found = numbers("B2", points=2)
    table = {50: (5280.5, 2470.8, 2166.0, 2224.2), 100: (1037.4, 988.2, 965.4, 952.2)}
    for pole, row in table.items():
        for delay, expected in enumerate(row):
            assert found[f"k_max_pole_{pole}_delay_{delay}"] == pytest.approx(expected, rel=5e-3)
    for delay, expected in enumerate((4528.2, 2433.9, 2164.5, 2181.7)):
        assert found[f"k_max_foh_pole_50_delay_{delay}"] == pytest.approx(expected, rel=5e-3)
    for delay in range(4):
        assert found[f"k_max_implicit_pole_50_delay_{delay}"] is None
        assert found[f"k_max_cutoff_50_hz_3_db_delay_{delay}"] == 0.0


def test_the_regions_of_fig_2_end_at_the_largest_stiffness():
    result = FIGURES["B2"].compute({**FIGURES["B2"].parameters, "points": 31})
    panel = result["data"]["50/2"]
    stable = [bool(panel["radius"][i, i] <= 1.0 + 1e-9) for i in range(31)]
    inside = [k <= panel["k_max"] for k in panel["k_n_per_m"]]
    assert stable[1:] == inside[1:]
    assert any(stable[1:]) and not all(stable)


def test_direct_coupling_of_app_b_fig_3():
    found = numbers("B3", points=2)
    for delay, expected in enumerate((2500.0, 335.3, 47.1, 0.0)):
        assert found[f"k_max_delay_{delay}"] == pytest.approx(expected, rel=5e-3)


def test_the_offsets_of_app_b_fig_5():
    found = numbers("B5")
    for delay, expected in ((0, 0.55), (2, 1.19), (3, 1.51)):
        assert found[f"ahead_delay_{delay}_mm"] == pytest.approx(expected, rel=5e-3)
        assert found[f"force_delay_{delay}_n"] == pytest.approx(1.0, rel=1e-4)
        assert found[f"pressed_delay_{delay}_mm"] == pytest.approx(2.0, rel=1e-4)


def test_the_offsets_follow_the_wave_impedance():
    model = {**FIGURES["B5"].parameters["model"], "master.impedance": 50.0}
    found = numbers("B5", model=model, delay_frames=[2])
    assert found["ahead_delay_2_mm"] == pytest.approx(1.19 / 2.0, rel=5e-3)


def test_peaks_and_felt_stiffness_of_app_a_fig_4():
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
    assert (FOLDER / f"{name}.png").stat().st_size < LARGEST_PICTURE


def test_the_pages_are_written_from_the_committed_results():
    known = pages.known_numbers(FOLDER)
    assert (FOLDER / "claims.md").read_text("utf-8") == pages.claims_page(known), "make figures"
    index = (FOLDER / "README.md").read_text("utf-8")
    assert index == pages.index_page(), "make figures"
    assert all(f"]({name}.png)" in index for name in FIGURES)


def test_a_changed_result_changes_the_claims():
    known = pages.known_numbers(FOLDER)
    known["B5"]["force_delay_0_n"] = 1.3
    assert "| 1.3 N |" in pages.claims_page(known)
    assert pages.claims_page(known) != (FOLDER / "claims.md").read_text("utf-8")


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


def test_the_contact_of_app_c_under_every_compensation():
    found = numbers("C5")
    assert found["made_by_delay_none_mj"] < -0.1
    assert found["lowest_after_printed_mj"] < -0.5  # the control: as printed it makes energy
    for kind in ("corrected", "ledger"):
        assert found[f"lowest_after_{kind}_mj"] >= -1e-9
    assert found["apart_from_environment_corrected"] < 0.02
    assert found["force_end_n"] == pytest.approx(found["contact_force_end_n"], rel=1e-3)


def test_the_z_width_of_app_c_with_a_ledger_is_that_without():
    curves = {name: FIGURES["C4"].parameters["curves"][name] for name in ("waves", "ledger")}
    found = numbers("C4", damping=[0.0, 12.0, 2], curves=curves)
    assert found["at_0_waves"] == pytest.approx(1394.4, rel=1e-3)
    assert found["at_0_ledger"] == pytest.approx(found["at_0_waves"], rel=0.02)


def test_the_experiments_of_app_d_with_right_and_wrong_filter():
    plain, wrong, right = numbers("D8"), numbers("D9"), numbers("D10")
    assert plain["spectral_radius"] < 1.0 and right["spectral_radius"] < 1.0
    assert wrong["spectral_radius"] > 1.05
    assert plain["force_noise_n"] ** 2 > 10.0 * right["force_noise_n"] ** 2
    assert wrong["force_largest_n"] == pytest.approx(8.0)  # the safety limit
    assert right["safety_events"] == 0 < plain["safety_events"]


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
