# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability maps: the same however they are computed, and whole after an interruption; what
``pmwvc stability`` and ``pmwvc map`` print, write and refuse.
"""

import functools
import json
import sys

import numpy as np
import pytest
from support import linear_loops
from support.command_line import here, refused
from support.map_points import point

from pmwvc_analysis.figures.model_charts import stability_map as draw
from pmwvc_analysis.maps.maps import Grid, MapAxis, compute, growth_per_s, write_data
from pmwvc_analysis.models.linearize import stable
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
    [(STIFFNESS, DELAY), (DAMPING, STIFFNESS), (TWO, MANY), (DELAY, DELAY)],
)
def test_a_map_is_what_its_points_are_one_by_one(x, y):
    of = grid(x, y)
    rows, columns = of.shape
    alone = [[point(of, row, place) for place in range(columns)] for row in range(rows)]
    np.testing.assert_allclose(computed(x, y), alone, rtol=1e-9)


def test_processes_change_nothing():
    np.testing.assert_array_equal(compute(grid(), workers=2), computed())


def test_every_file_holds_the_same_map(tmp_path):
    of, radius = grid(), computed()
    write_data(tmp_path, of, radius)
    draw(tmp_path, of, radius)
    content = json.loads((tmp_path / "map.json").read_text())
    assert content["spectral_radius"] == radius.tolist()
    assert content["stable"] == stable(radius).tolist()
    assert (tmp_path / "map.png").stat().st_size > 10_000
    assert "<svg" in (tmp_path / "map.svg").read_text()


def test_without_dask_the_message_names_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(PmwvcError, match="leave --dask out"):
        compute(grid(), dask="tcp://127.0.0.1:1")


def test_a_dask_cluster_computes_the_same():
    distributed = pytest.importorskip("distributed", reason="the optional Dask is not installed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
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


PLAIN = ("--set", "channel=plain")
FIRST_ORDER = (*PLAIN, "--set", "master.filter.kind=first_order")
LATE = ("--set", "server.coupling=one_frame_late", "--set", "master.hold=zoh", *FIRST_ORDER)


@pytest.fixture
def pmwvc(tmp_path):
    return functools.partial(here, cwd=tmp_path)


def test_stability_answers_with_documented_keys(pmwvc):
    result = pmwvc("stability", "carry_16ms", *LATE, "--json")
    found = json.loads(result.stdout)
    assert found["k_max"] == pytest.approx(2166.0, rel=5e-3)
    assert found["stable"] is True and found["spectral_radius"] < 1.0
    assert found["k_max_bound"] == 1e6
    assert found["rigid_body_modes"] == 4
    assert found["hyperperiod_ticks"] == 8
    assert found["states"] == 22  # of each filter two, as of any section
    assert any("Grip" in note for note in found["notes"])


def test_stability_without_a_limit_is_null_in_json_and_stated_in_words(pmwvc):
    words = ("stability", "carry_16ms", *FIRST_ORDER)
    assert json.loads(pmwvc(*words, "--json").stdout)["k_max"] is None
    assert "stable at every contact stiffness up to 1,000,000 N/m" in pmwvc(*words).stdout


DELAYS = "link.delay_s=0:0.01:2"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("stability", "carry_16ns"), "did you mean carry_16ms"),
        (("stability", "carry_16ms", "--set", "device.friction=0.1"), "use 'pmwvc simulate'"),
        (("stability", "carry_16ms", "--set", "device.encoder_step_m=1e-5"), "is not linear"),
        (
            ("stability", "carry_16ms", "--set", "user1.master.rate_drop=997",
             "--set", "user2.master.rate_drop=991"),
            "common factors",
        ),
        (
            ("map", "wall", "--x", "device.mas=1:2:3", "--y", "link.delay_s"),
            "--x: device.mas: there is no such parameter; did you mean",
        ),
        (("map", "wall", "--x", "device.mass=2:1:3", "--y", "link.delay_s"), "FIRST:LAST:COUNT"),
        (("map", "wall", "--x", DELAYS, "--y", DELAYS), "two different"),
        (("map", "wall", "--x", "server.coupling", "--y", "link.delay_s"), "FIRST:LAST:COUNT"),
    ],
)  # fmt: skip
def test_a_mistake_is_reported_once_and_clearly(pmwvc, words, said):
    assert said in refused(pmwvc(*words))


def test_a_map_is_written_in_a_folder_of_its_own(pmwvc, tmp_path):
    words = (
        "map", "carry_16ms", *LATE, "--x", "server.contact_stiffness=2000:2600:13",
        "--y", "link.delay_s=0.008:0.016:2", "--json",
    )  # fmt: skip
    found = json.loads(pmwvc(*words, "--out", "drawn").stdout)
    assert [row.count(True) for row in found["stable"]] == [10, 4]
    kinds = {path.suffix for path in (tmp_path / "drawn").glob("map.*")}
    assert kinds == {".png", ".svg", ".json"}
    assert "drawn is not empty" in refused(pmwvc(*words, "--out", "drawn"))
    assert pmwvc(*words).returncode == 0
    (folder,) = (tmp_path / "sessions").iterdir()
    assert folder.name.endswith("-carry_16ms-map")


def test_what_decides_a_scenario_is_no_axis_of_a_map(pmwvc):
    message = refused(pmwvc("map", "wall", "--x", "dof=1:2:2", "--y", "link.delay_s"))
    assert "wall: dof: decides what a scenario is" in message
