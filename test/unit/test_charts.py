# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing of figures: no peak is lost, no curve hides another, colours stay apart."""

import base64
import itertools
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import handmade

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Band, Chart, Curve, Dots, Level, Panel
from pmwvc_analysis.charts.chart_files import MOST_NUMBERS, figure, payload, thinned
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.figures import charts
from pmwvc_analysis.figures.recorded import numbered
from pmwvc_analysis.report import report
from pmwvc_view.web.access import PAGE

SUPPORT = Path(handmade.__file__).parent
PLAIN_TINTS = ("object", "target", "alarm", "paper", "ink", "soft")


def many_users(count, dof=1):
    return handmade.session(users=count, dof=dof, duration_s=1.6)


@pytest.mark.parametrize(("block", "known"), [(0, style.LIGHT), (1, style.DARK)])
def test_the_live_page_has_the_colours_of_figures(block, known):
    blocks = re.findall(r":root \{(.*?)\}", (PAGE / "page.css").read_text("utf-8"), re.DOTALL)
    found = dict(re.findall(r"--(\w+): (#\w+);", blocks[block]))
    shared = [*(f"u{place}" for place in range(8)), *PLAIN_TINTS]
    assert {name: found[name] for name in shared} == {name: known[name] for name in shared}


def hides(upper, lower):
    """Whether a curve drawn over another of the same course leaves nothing of it to see."""
    return not upper.dash and upper.width > lower.width - 0.7


@pytest.mark.parametrize("count", [1, 2, 6, 8])
@pytest.mark.parametrize("dof", [1, 3])
def test_no_curve_hides_another_that_it_coincides_with(count, dof):
    for chart in charts(many_users(count, dof), None):
        for panel in chart.panels:
            for lower, upper in itertools.combinations(panel.lines, 2):
                assert not hides(upper, lower), (chart.name, lower.label, upper.label)
                assert (lower.dash, lower.width) != (upper.dash, upper.width)


@pytest.mark.parametrize(("period", "gaps"), [(0.001, 1), (0.0, 0)])
def test_a_gap_in_the_recording_is_a_gap_in_the_curve(period, gaps):
    x = np.concatenate([np.arange(0.0, 1.0, 0.001), np.arange(2.0, 3.0, 0.001)])
    chart = Chart("c", "C", "", [Panel("y", [Curve("a", x, np.sin(x), "u0", period=period)])])
    (line,) = figure(chart).axes[0].get_lines()
    left = np.flatnonzero(np.isnan(line.get_xdata()))
    assert len(left) == gaps
    assert (x[left - 1] == 0.999).all()


def test_a_hole_in_a_users_trace_is_a_band_through_its_panels():
    traces = handmade.session()
    handmade.without_blocks(traces.users[0], slice(125, 188))
    (band,) = recorded.bands(traces)
    np.testing.assert_allclose(band.span, (1.0, 1.504))
    assert band.label == "user1: not recorded"
    assert recorded.bands(handmade.session()) == []
    for chart in charts(traces, None)[:2]:
        assert band in chart.panels[0].bands


def test_a_loop_that_did_not_run_is_not_called_a_hole():
    traces = handmade.session()
    user = traces.users[0]
    user.time_s = user.time_s + np.where(user.tick >= 1000, 0.3, 0.0)
    (band,) = recorded.bands(traces)
    np.testing.assert_allclose(band.span, (0.999, 1.3))
    assert band.label == "user1: did not run"


@given(
    st.lists(st.floats(-1e6, 1e6, allow_subnormal=False), min_size=1, max_size=400),
    st.integers(4, 200),
)
def test_thinning_keeps_the_extremes_of_every_column(values, most):
    y, x = np.array(values), np.arange(len(values), dtype=float)
    rows = thinned(x, y, period=1.0, most=most)
    assert len(rows) <= max(most, 4) + 4
    columns = np.floor(x / max((len(x) - 1) / (most // 4), 1e-9)) if len(x) > most else x
    for each in np.unique(columns):
        here, kept = y[columns == each], y[rows][columns[rows] == each]
        assert (kept.min(), kept.max()) == (here.min(), here.max())
        assert {here[0], here[-1]} <= set(kept)


def test_what_a_report_holds_is_exact_and_complete_while_it_is_small():
    x, y = np.arange(5000) * 0.001, np.random.default_rng(3).normal(size=5000)
    chart = Chart("c", "C", "", [Panel("y", lines=[Curve("a", x, y, "u0", period=0.001)])])
    data, complete = payload([chart], (0.0, 5.0), [])
    line = data["charts"][0]["panels"][0]["lines"][0]
    assert complete
    for name, values in (("x", x), ("y", y)):
        stored = np.frombuffer(base64.b64decode(data["arrays"][line[name]]), dtype="<f4")
        np.testing.assert_array_equal(stored, values.astype("<f4"))


def test_a_long_session_is_thinned_and_keeps_peak_and_hole():
    x = np.arange(500_000) * 0.001
    y = np.sin(x)
    y[323_456], y[170_001] = 9.0, -9.0
    y[375_000:400_000] = np.nan
    lines = [Curve(f"{n}", x, y + 0.0 * n, "u0", period=0.001) for n in range(3)]
    data, complete = payload([Chart("c", "C", "", [Panel("y", lines=lines)])], (0.0, 500.0), [])
    assert not complete
    assert len(json.dumps(data)) < 6 * MOST_NUMBERS
    rows = thinned(x, y, period=0.001, most=20_000)
    assert len(rows) <= 20_100
    assert (np.nanmin(y[rows]), np.nanmax(y[rows])) == (-9.0, 9.0)
    assert np.isnan(y[rows]).sum() == 1


def by_script(data, tmp_path):
    """Legend and drawing of every panel by figure, as the report's script makes them."""
    if shutil.which("node") is None:
        pytest.skip("no node on this machine runs the report's script")
    (tmp_path / "data.json").write_text(str(data))
    script, page = Path(report.__file__).with_name("chart.js"), SUPPORT / "small_page.js"
    command = ["node", page, script, tmp_path / "data.json"]
    made = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    panels = json.loads(made)
    return {
        name: [[ET.fromstring(f"<svg>{part}</svg>") for part in panel] for panel in found]
        for name, found in panels.items()
    }


def test_an_event_stands_at_its_time_in_every_figure(tmp_path):
    traces = handmade.session()
    traces.events = [{"time_s": 2.0, "who": "user1", "kind": "contact", "what": "touched"}]
    drawn = charts(traces, None)
    data, _ = report.figure_data(drawn, traces, numbered(traces.events))
    assert json.loads(str(data))["events"] == [[2.0, "1", "1. 2.000 s: user1 touched"]]
    found = by_script(data, tmp_path)
    assert found.keys() == {chart.name for chart in drawn}
    for panels in found.values():
        for _, plot in panels:
            (mark,) = plot.findall(".//path[@class='ev']")
            assert mark.get("d").startswith(("M523.", "M524."))


def test_the_script_draws_every_curve_with_its_gap_and_names_it_once(tmp_path):
    x = np.concatenate([np.arange(0.0, 1.0, 0.001), np.arange(2.0, 3.999, 0.001)])
    lines = [Curve("a < b", x, np.sin(x), "u0", period=0.001), Curve("a < b", x, -x, "u1", (2, 3))]
    dots = [Dots("</script>", np.ones(2), np.ones(2), "alarm", "cross")]
    levels, bands = [Level("limit", 0.5)], [Band("hole", (1.0, 2.0), "soft")]
    panel = Panel("y", lines=lines, dots=dots, levels=levels, bands=bands, title="user1")
    data, _ = report.figure_data([Chart("c", "C", "", [panel])], handmade.session(), [])
    assert "</script>" not in data
    [[[legend, plot]]] = by_script(data, tmp_path).values()
    curves = [each.get("d") for each in plot.findall(".//path[@class='line']")]
    assert [curve.count("M") for curve in curves] == [1, 2, 1]  # the level, and both curves
    assert plot.find(".//path[@class='dots cross']").get("d").count("M") == 1
    assert len(plot.findall(".//rect[@class='band']")) == 1
    names = [each.get("data-label") for each in legend.findall(".//button")]
    assert names == ["a < b", "</script>"]
    assert "".join(legend.itertext()) == "user1ya < b</script>hole· · · limit"
