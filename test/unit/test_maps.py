# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps: the same however they are computed, and whole after an interruption."""

import csv
import functools
import json
import sys

import numpy as np
import pytest
from support import linear_loops
from support.map_points import point

from pmwvc_analysis.figures.model_charts import stability_map as draw
from pmwvc_analysis.maps.maps import Grid, MapAxis, boundary_of, compute, growth_per_s, write_data
from pmwvc_core.errors import PmwvcError

STIFFNESS = MapAxis("server.contact_stiffness", tuple(np.linspace(0.0, 3000.0, 7).tolist()))
DELAY = MapAxis("link.delay_s", (0.0, 0.008, 0.016))
DAMPING = MapAxis("server.contact_damping", (0.0, 10.0, 20.0))
MANY = MapAxis(STIFFNESS.name, tuple(np.linspace(0.0, 3000.0, 17).tolist()))  # in threes
TWO = MapAxis(DAMPING.name, (0.0, 10.0))


def grid(x=STIFFNESS, y=DELAY):
    return Grid(linear_loops.scenario(server__coupling="one_frame_late"), x, y)


@functools.cache
def computed(x=STIFFNESS, y=DELAY):
    """The map of a grid, computed in this process: for several tests."""
    return compute(grid(x, y), workers=1)


@pytest.mark.parametrize(
    ("x", "y"),
    [(STIFFNESS, DELAY), (DELAY, STIFFNESS), (DAMPING, STIFFNESS), (TWO, MANY), (DELAY, DELAY)],
)
def test_a_map_is_what_its_points_are_one_by_one(x, y):
    of = grid(x, y)
    found = compute(of)
    rows, columns = of.shape
    alone = [[point(of, row, place) for place in range(columns)] for row in range(rows)]
    np.testing.assert_allclose(found, alone, rtol=1e-9)


def test_the_boundary_of_the_map_is_that_of_app_b():
    fine = MapAxis(STIFFNESS.name, tuple(np.linspace(2000.0, 2600.0, 61).tolist()))
    of = grid(fine)
    crossings = boundary_of(of, compute(of))
    assert crossings[0] is None
    assert crossings[1:] == pytest.approx([2470.8, 2166.0], rel=5e-3)


def test_processes_change_nothing():
    np.testing.assert_array_equal(compute(grid(), workers=2), computed())


def test_every_file_holds_the_same_map(tmp_path):
    of, radius = grid(), computed()
    write_data(tmp_path, of, radius)
    draw(tmp_path, of, radius)
    content = json.loads((tmp_path / "map.json").read_text())
    assert content["spectral_radius"] == radius.tolist()
    with (tmp_path / "map.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["spectral_radius"]) for row in rows] == radius.ravel().tolist()
    assert {row["stable"] for row in rows} == {"0", "1"}
    assert (tmp_path / "map.png").stat().st_size > 10_000
    assert "<svg" in (tmp_path / "map.svg").read_text()


def test_without_dask_the_message_names_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(PmwvcError, match="leave --dask out"):
        compute(grid(), dask="tcp://127.0.0.1:1")


def test_a_dask_cluster_computes_the_same():
    distributed = pytest.importorskip("distributed", reason="the optional Dask is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        found = compute(grid(), dask=cluster.scheduler_address)
    np.testing.assert_array_equal(found, computed())


def test_a_period_that_is_no_multiple_of_the_tick_is_refused_before_anything_is_computed():
    period = MapAxis("server.period_s", (0.008, 0.0085, 0.009))
    with pytest.raises(PmwvcError, match=r"server\.period_s = 0\.0085: .* 0\.001 s .*8\.5 ticks"):
        compute(grid(STIFFNESS, period))


def test_growth_rates_compare_across_periods_where_radii_do_not():
    """Free motion braked by the device alone dies out at the rate b_hd/(m + b tau/2): a longer
    period changes the lag tau a little, the hyperperiod ninefold.
    """
    period = MapAxis("server.period_s", (0.008, 0.009, 0.016))
    free = linear_loops.scenario(
        server__contact_stiffness=0.0, server__contact_damping=0.0, device__damping=0.01
    )
    of = Grid(free, MapAxis("server.object_mass", (2.0,)), period)
    found = compute(of)
    radius, rate = found[:, 0], growth_per_s(of, found)[:, 0]
    assert (1.0 - radius).max() > 5.0 * (1.0 - radius).min()  # hyperperiods of 8, 72 and 16 ms
    np.testing.assert_allclose(rate, rate[0], rtol=0.2)
    assert rate[0] < 0.0
