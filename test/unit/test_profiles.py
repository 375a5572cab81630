# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Profiles of devices: every number with its source, unknown ones absent, mistakes named."""

import pytest
from support.vendor_setup import vendor_setup

from pmwvc_core.errors import DeviceError
from pmwvc_core.params import SafetyParams
from pmwvc_master.devices import limits_of
from pmwvc_master.devices.force_dimension import ForceDimensionDevice, ForceDimensionParams
from pmwvc_master.devices.profile import FOLDER, models_of, profile_of

SHIPPED = [(file.parent.name, file.stem) for file in sorted(FOLDER.glob("*/*.yaml"))]


@pytest.mark.parametrize(("device", "model"), SHIPPED)
def test_a_shipped_profile_has_a_source_for_every_number_and_a_possible_desk_device(device, model):
    known = profile_of(device, model)
    assert all(len(text) > 8 for text in known.sources.values())
    assert len(known.lines()) == len(known.sources)
    assert 0.02 <= known.workspace_m <= 0.3
    assert known.max_force_n is None or 1.0 <= known.max_force_n <= 40.0
    if None not in (known.continuous_force_n, known.max_force_n):
        assert known.continuous_force_n <= known.max_force_n


@pytest.mark.parametrize(
    ("asked", "lever_m", "limit"),
    [(0.0, 0.05, 0.2), (0.0, 0.01, 0.08), (0.1, 0.05, 0.1), (0.3, 0.05, 0.2)],
)
def test_the_torque_is_never_above_the_devices_peak(asked, lever_m, limit):
    """By default the torque of the largest force at the lever; a device without torque has it."""
    setup = vendor_setup("force_dimension", 3)
    safety = SafetyParams(max_force=8.0, max_torque=asked)
    info = ForceDimensionDevice(setup, ForceDimensionParams("sigma.7")).info
    assert limits_of(info, safety, lever_m).max_torque == pytest.approx(limit)
    info = ForceDimensionDevice(setup, ForceDimensionParams("omega.7")).info
    assert limits_of(info, safety, lever_m) == safety


def test_the_models_are_the_ones_asked_for():
    assert {"inverse3", "minverse"} == set(models_of("haply"))
    assert {"omega.3", "omega.6", "delta.3", "sigma.7", "falcon"} <= set(
        models_of("force_dimension")
    )
    assert {"touch", "touch_x"} <= set(models_of("touch"))


OWN = """
max_force_n: {value: 11, source: measured}
apparent_mass_kg: {value: 0.12, source: measured}
workspace_m: {value: 0.07, source: measured}
encoder_step_m: {value: 1e-5, source: measured}
continuous_force_n: {value: 4.0, source: measured}
"""


def test_a_laboratorys_own_file_declares_what_it_measured(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(OWN)
    setup = vendor_setup("force_dimension", 3)
    device = ForceDimensionDevice(setup, ForceDimensionParams(str(file)))
    info = device.info
    assert (info.max_force, info.continuous_force, info.apparent_mass) == (11, 4.0, 0.12)
    assert (info.workspace_m, info.encoder_step_m) == (0.07, 1e-5)
    assert limits_of(info, SafetyParams(max_force=20.0)).max_force == 11


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("mass: {value: 1, source: x}", "argument 'mass'; .* there are max_force_n, .*joints"),
        ("max_force_n: 12", "TypeError: .*lines are like 'workspace_m: {value: 0.1, source:"),
        ("max_force_n: {value: 12}", "KeyError: 'source'"),
        ("workspace_m: {value: -1, source: x}", "workspace_m = -1.0: must be > 0 m"),
        ("workspace_m: {value: .nan, source: x}", "workspace_m = nan: must be > 0 m"),
        ("workspace_m: {value: wide, source: x}", "workspace_m = 'wide': must be > 0 m"),
        ("centre_m: {value: [0, 1], source: x}", "ValueError: not enough values"),
        ("centre_m: {value: [0, 1, a], source: x}", "could not convert string to float: 'a'"),
        ("- 12", "AttributeError"),
        ("a: {", "mine.yaml.*line"),
    ],
)
def test_a_file_that_is_no_profile_is_refused_with_the_line_to_write(tmp_path, text, problem):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises(DeviceError, match=problem):
        profile_of("touch", str(file))


def test_a_model_without_a_profile_is_refused_with_those_there_are(tmp_path):
    with pytest.raises(DeviceError, match=r"touch\.model = 'toch': must be omni, touch, "):
        profile_of("touch", "toch")
    with pytest.raises(DeviceError, match=r"No such file"):
        profile_of("touch", str(tmp_path / "none.yaml"))
