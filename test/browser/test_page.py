# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page itself: settings, its token, what it loads, how it looks and what it reads out."""

import numpy as np
import pytest
from playwright.sync_api import expect
from support.page_server import TOKEN, served
from support.pages import complaints_of
from support.plain import load
from support.simulated import judged, simulated

from pmwvc_view.recorded import replay_page

PICTURE = "() => document.getElementById('scene').toDataURL()"


def test_proposed_setting_is_predicted_then_applied(visit):
    with served() as live:
        page, other = visit(live.address), visit(live.address)
        page.locator("#setting-link-delay_s").fill("40")
        answer = page.locator("#answer")
        live.until(lambda: "The exact model: stable" in answer.inner_text(), "a prediction")
        assert live.now("user1.delay_up") == pytest.approx(0.016)  # a proposal changes nothing
        page.locator("#apply").click()
        live.until(lambda: live.now("user1.delay_up") > 0.039, "the new delay")
        told = other.locator("[data-path='link.delay_s'] output")
        live.until(lambda: told.inner_text().startswith("40 ms"), "the same on other pages")

        page.locator("#setting-controller").select_option("direct")
        live.until(lambda: "The exact model: not stable" in answer.inner_text(), "a warning")
        assert answer.inner_text().lower().count("not stable") == 1
        expect(page.locator("#apply")).to_have_text("Apply and start again")
        generation = live.session.generation
        page.locator("#apply").click()
        live.until(lambda: live.session.generation > generation, "a new beginning")
        chosen = other.locator("#setting-controller")
        live.until(lambda: chosen.input_value() == "direct", "the same on other pages")


def test_page_that_lacks_its_token_says_so(visit):
    """What is refused: ``unit/test_page_access.py``."""
    with served() as live:
        lost = visit(live.address.replace(TOKEN, "another"), shown=False)
        verdict = lost.locator("#verdict")
        live.until(lambda: "lacks its token" in verdict.inner_text(), "a hint at the address")


@pytest.mark.parametrize(("scheme", "name"), [("light", "live"), ("dark", "cube_3d")])
def test_page_fits_phone_and_loads_nothing_from_elsewhere(visit, scheme, name):
    with served(name=name) as live:
        phone = {"width": 390, "height": 844}
        requests = []
        page = visit("about:blank", shown=False, viewport=phone, color_scheme=scheme)
        page.on("request", lambda request: requests.append(request.url))
        complaints = complaints_of(page)
        page.goto(live.address)
        page.locator("#scene[data-users='2']").wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.evaluate("document.documentElement.scrollHeight") > 844
        assert {url.split("/")[2] for url in requests} == {live.address.split("/")[2]}
        assert complaints == []


def test_state_is_read_out_and_no_motion_where_none_is_wanted(visit):
    with served() as live:
        page = visit(live.address, reduced_motion="reduce")
        spoken = page.locator("#spoken")
        said = lambda: "user 1 coupled, not held" in spoken.inner_text()  # noqa: E731
        live.until(said, "the state in words")
        assert "newtons" in spoken.inner_text()

        def at_rest(shown):
            seen = shown.evaluate(PICTURE)
            live.pass_by(20)
            return shown.evaluate(PICTURE) == seen

        live.until(lambda: at_rest(page), "a picture that stays as it is")
        moving = visit(live.address)
        assert not at_rest(moving)  # the control: packets on their way


PLACES = """(delay_s) => import("/packets.js").then(({ PacketFlow, SLOWER }) => {
  const flow = new PacketFlow(true), from_s = 100.0, travel_s = SLOWER * delay_s;
  const places = [], late_s = flow.late_s;
  flow.take([{ link: 0, sent: 5.0, arrived: 5.0 + delay_s }], from_s, 5.0);
  const context = new Proxy({}, { get: (_, name) => (...given) => {
    if (name === "arc") places.push(given[0]);
  }, set: () => true });
  return [0.25, 0.5, 0.75, 1.001].map((way) => {
    places.length = 0;
    flow.draw(context, 0, "red", 3, [0, 0], [1000, 0], from_s + late_s + way * travel_s);
    return Math.max(-1, ...places);
  });
})"""


def test_packet_is_drawn_as_far_on_its_way_as_its_delay_has_passed(anything):
    """25 times slower than it is; after its delay it has arrived."""
    for delay_s in (0.016, 0.08):
        places = anything.evaluate(PLACES, delay_s)
        assert places == pytest.approx([250.0, 500.0, 750.0, -1.0])


def test_file_beside_the_report_plays_the_session_without_a_server(visit, tmp_path):
    scenario = load("carry_16ms", duration_s=6.0)
    traces = simulated(scenario)
    file = tmp_path / "replay.html"
    file.write_text(replay_page(traces, scenario, judged(scenario)), "utf-8")
    recorded_n = abs(float(traces.users[0].f_applied[4192, 0]))
    requests, page = [], visit("about:blank", shown=False)
    complaints = complaints_of(page)
    page.on("request", lambda request: requests.append(request.url.split(":")[0]))
    page.goto(file.as_uri())
    time = page.locator("#seek-time")
    expect(time).to_have_text("0.0 of 6.0 s")
    page.locator("#seek").fill("4.2")
    expect(time).to_have_text("4.2 of 6.0 s")
    expect(page.locator("[data-user=user1] .state")).to_have_text(f"coupled · {recorded_n:.2f} N")
    expect(page.locator("[data-user=user1] .price")).to_contain_text("ahead of its avatar")
    expect(page.locator("#verdict")).to_contain_text("The whole session: Stable")
    page.locator("#play").click()
    expect(time).not_to_have_text("4.2 of 6.0 s")
    assert 4.2 < float(time.inner_text().split()[0]) <= 6.0  # on from there
    assert set(requests) <= {"file", "data", "blob"} and complaints == []


def test_file_beside_the_report_shows_the_bodies_of_every_time(visit, tmp_path):
    pytest.importorskip("mujoco")
    haste = ("task.grip_s=0.3", "task.grip_rise_s=0.5", "task.move_s=1.5", "task.move_rise_s=1")
    scenario = load("lift", settings_texts=haste, duration_s=4.0)
    traces = simulated(scenario)
    file = tmp_path / "replay.html"
    file.write_text(replay_page(traces, scenario, judged(scenario)), "utf-8")
    page = visit("about:blank", shown=False)
    complaints = complaints_of(page)
    page.goto(file.as_uri())
    page.locator("#scene[data-users='2']").wait_for()
    highest_s = float(traces.server.time_s[np.argmax(traces.server.poses["box"][:, 2])])
    for time_s in (1.0, round(highest_s, 2)):
        page.locator("#seek").fill(str(time_s))
        index = int(np.searchsorted(traces.server.time_s, time_s + 1e-6)) - 1
        z_m = float(traces.server.poses["box"][index, 2])
        page.wait_for_function(
            "(z) => Math.abs(document.getElementById('space').bodies.get('box').position[2] - z)"
            " < 2e-4",
            arg=z_m,
        )
    assert z_m > 0.01 and complaints == []
