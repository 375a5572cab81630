# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings are read as they are written, or refused with what they hold and what to do."""

import numpy as np
import pytest

from pmwvc_core.errors import RecordingError
from pmwvc_core.params import OperatorParams
from pmwvc_core.plant.hands import fade, load_recording, resample

TICK_S = 0.001


def load(path, *, dof=2, **options):
    params = OperatorParams(kind="playback_motion", file=str(path), **({"fade_s": 0.0} | options))
    return load_recording(params, tick_s=TICK_S, dof=dof)


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught:
        load(path, **options)
    assert str(path) in str(caught.value)
    return str(caught.value)


@pytest.fixture
def table(tmp_path):
    """Write a file of text: t, a, b, where b has words."""
    file = tmp_path / "hand.csv"
    rows = [f"{0.001 * k:.3f},{k},{'x' if k == 3 else -k}" for k in range(50)]
    file.write_text("t, position ,b\n" + "\n".join(rows) + "\n")
    return file


def test_text_columns_by_name_and_by_number(table):
    np.testing.assert_allclose(load(table, columns="position")[:, 0], np.arange(50), atol=1e-9)
    both = load(table, columns="1, 0", time_column="t")
    np.testing.assert_allclose(both, np.arange(50)[:, None] * [1.0, 0.001], atol=1e-9)


@pytest.mark.parametrize(
    ("separator", "header"), [(",", ""), (";", "a@b\n"), ("\t", "a@b\n"), ("   ", "")]
)
def test_text_with_any_separator_with_and_without_names(tmp_path, separator, header):
    file = tmp_path / "two.txt"
    rows = "\n".join(f"{k}{separator}{2 * k} " for k in range(20))
    file.write_text("# remark\n\n" + header.replace("@", separator) + rows, encoding="utf-8-sig")
    got = load(file, columns="a,b" if header else "0,1")
    np.testing.assert_allclose(got, np.outer(np.arange(20), [1.0, 2.0]), atol=1e-9)


def test_a_single_column_needs_no_name_and_scale_and_offset_make_si_units(tmp_path):
    np.save(tmp_path / "one.npy", np.arange(10.0))
    got = load(tmp_path / "one.npy", scale=0.5, offset=3.0)
    np.testing.assert_allclose(got, 3.0 + 0.5 * np.arange(10)[:, np.newaxis])
    (tmp_path / "one.csv").write_text("t,f\n" + "\n".join(f"{k / 1000},{k}" for k in range(10)))
    np.testing.assert_allclose(load(tmp_path / "one.csv", time_column="t")[:, 0], np.arange(10))


def test_a_faulty_table_is_refused_with_its_columns(table, tmp_path):
    assert "no column 'f'; there are t, position, b, or by number 0 to 2" in refusal(
        table, columns="f"
    )
    assert "more than one column: choose from t, position, b" in refusal(table)
    assert "1 rows hold a value that is not a finite number, the first is row 3" in refusal(
        table, columns="b"
    )
    assert "no such file (looked in " in refusal(tmp_path / "none.csv")
    assert "empty" in refusal(_write(tmp_path / "a.csv", "\n# only\n"))
    for array in (np.array(["x", "y"]), np.array([{}], dtype=object), np.array(1.0)):
        np.save(tmp_path / "a.npy", array)
        assert "no array of numbers" in refusal(tmp_path / "a.npy")
    assert "a recording needs at least 2" in refusal(_write(tmp_path / "b.csv", "x\n1\n"))
    (tmp_path / "c.csv").write_bytes(b"\xff\xfe\x00")
    assert "not text" in refusal(tmp_path / "c.csv")
    ragged = _write(tmp_path / "d.csv", "a,b\n1,2\n3\n")
    assert "Line #3 (got 1 columns instead of 2); repair the file" in refusal(ragged, columns="b")
    with pytest.raises(RecordingError, match=r"operator\.file is empty"):
        load("")

    file = _write(tmp_path / "e.csv", "t,f\n0,1\n1,nan\n2,inf\n3,4\n")
    text = refusal(file, columns="f", time_column="t")
    assert "2 rows hold a value that is not a finite number, the first is row 1" in text
    file = _write(tmp_path / "f.csv", "t,f\n0,1\n1,2\n1,3\n")
    assert "t does not rise at row 2" in refusal(file, columns="f", time_column="t")


def test_resampling_removes_what_the_ticks_cannot_hold_and_keeps_the_rest_without_lag():
    times = np.arange(4000) / 2000.0
    slow = np.sin(2 * np.pi * 7.0 * times)
    fast = np.sin(2 * np.pi * 800.0 * times)  # would fold down to 200 Hz
    got = resample((slow + fast)[:, None], times, tick_s=TICK_S)[:, 0]
    inside = slice(100, -100)
    np.testing.assert_allclose(got[inside], slow[::2][inside], atol=2e-3)
    folded = (slow + fast)[::2] - slow[::2]
    assert np.abs(folded).max() > 0.9  # the control: taking every second sample


def test_uneven_times_and_slow_recordings_are_interpolated_smoothly():
    rng = np.random.default_rng(4)
    times = np.sort(rng.uniform(0.0, 2.0, 400))
    times = times[np.concatenate([[True], np.diff(times) > 1e-4])]
    got = resample(np.sin(3.0 * times)[:, None], times, tick_s=TICK_S)[:, 0]
    wanted = np.sin(3.0 * (times[0] + TICK_S * np.arange(len(got))))
    np.testing.assert_allclose(got, wanted, atol=5e-3)
    steps = resample(np.array([0.0, 0.0, 1.0, 1.0])[:, None], np.arange(4.0), tick_s=TICK_S)
    assert steps.min() == 0.0 and steps.max() == 1.0  # no overshoot


def test_a_signal_at_the_tick_rate_passes_unchanged():
    values = np.random.default_rng(6).standard_normal((200, 2))
    got = resample(values, 20.3 + TICK_S * np.arange(200), tick_s=TICK_S)
    np.testing.assert_allclose(got, values, atol=1e-9)


def test_fading_leads_in_from_zero_and_out_to_zero():
    faded = fade(np.ones((1000, 1)), fade_s=0.1, tick_s=TICK_S)[:, 0]
    assert faded[0] == faded[-1] == 0.0
    np.testing.assert_array_equal(faded[100:900], 1.0)
    np.testing.assert_allclose(faded, faded[::-1])
    assert np.abs(np.diff(faded)).max() < 0.02
    short = fade(np.ones((50, 1)), fade_s=0.1, tick_s=TICK_S)[:, 0]
    assert short[0] == short[-1] == 0.0 and short.max() > 0.9
    np.testing.assert_array_equal(fade(np.ones((9, 1)), fade_s=0.0, tick_s=TICK_S), 1.0)


def _write(path, text):
    path.write_text(text)
    return path
