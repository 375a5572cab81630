# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A person at a page holds a handle: by mouse, finger, keys and gamepad; a page that goes silent
lets go.
"""

from contextlib import contextmanager

import numpy as np
import pytest
from playwright.sync_api import expect
from support.page_server import served
from support.pages import HANDLE, Pointer

WALL = ["server.environment=wall", "server.gap_m=0.002"]
SLOW_SLEW, SLOW_N_PER_TICK = "safety.max_slew=200", 0.2  # a grip let go at once would be a step
FAKE_GAMEPAD = """
window.pad = {connected: true, axes: [0, 0, 0, 0], buttons: [{pressed: false}], rumbles: []};
window.pad.vibrationActuator = {playEffect: (kind, effect) => window.pad.rumbles.push(effect)};
navigator.getGamepads = () => [window.pad];
"""
HELD_BACK = """
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  if (text.includes('"take"')) window.goes = () => send.call(this, text);
  else send.call(this, text);
};
"""
BUSY = "() => { const until = performance.now() + 1200; while (performance.now() < until); }"
HIDE = """() => {
  Object.defineProperty(document, "hidden", {get: () => true});
  document.dispatchEvent(new Event("visibilitychange"));
}"""


@contextmanager
def _still(page, how):
    """Keep a page's script from running: busy for a while, or stopped until the block ends."""
    if how == "busy":
        page.evaluate(BUSY)
        yield
        return
    devtools = page.context.new_cdp_session(page)
    devtools.send("Debugger.enable")
    devtools.send("Debugger.pause")
    yield
    devtools.send("Debugger.disable")


def _pressed(live) -> bool:
    return live.now("user1.held") == 1.0 and live.now("user1.f_applied") > 0.5


@pytest.mark.parametrize("touch", [False, True], ids=["mouse", "finger"])
def test_drag_lifts_force_and_release_lets_go(visit, touch):
    with served(WALL, users=1) as live:
        page = visit(live.address, has_touch=touch)
        assert np.abs(live.forces("user1")).max() == 0.0
        pointer = Pointer(page, touch=touch)
        pointer.press()
        pointer.move(0.03)
        live.until(lambda: _pressed(live), "a force at the wall")
        live.pass_by(30)
        live.until(lambda: _pressed(live), "a hand that holds on although nothing moves")
        expect(page.locator(".user .state")).to_contain_text("coupled, held")
        pointer.release()
        live.until(lambda: live.now("user1.held") == 0.0, "an open hand")
        live.until(lambda: abs(live.now("user1.f_applied")) < 0.1, "no force")


def test_drag_that_ends_before_the_handle_is_taken_is_followed(visit):
    with served(WALL, users=1) as live:
        page = visit(live.address, script=HELD_BACK)
        pointer = Pointer(page)
        pointer.press()
        pointer.move(0.03)
        live.until(lambda: page.evaluate("Boolean(window.goes)"), "a take that is held back")
        assert live.now("user1.held") == 0.0
        page.evaluate("goes()")
        live.until(lambda: _pressed(live), "a force at the wall")


def test_keys_move_held_handle_and_escape_lets_go(visit):
    with served(users=1) as live:
        page = visit(live.address)
        page.locator("#scene").focus()
        start_m = live.now("user1.x_m")
        page.keyboard.down("ArrowLeft")
        live.pass_by(10)
        page.keyboard.up("ArrowLeft")
        assert live.now("user1.x_m") == start_m  # the control: nobody holds the handle
        page.keyboard.press("Space")
        live.until(lambda: live.now("user1.held") == 1.0, "a closed hand")
        page.keyboard.down("ArrowLeft")
        live.until(lambda: live.now("user1.x_m") < start_m - 0.02, "20 mm to the left")
        page.keyboard.up("ArrowLeft")
        assert live.now("user1.held") == 1.0
        page.keyboard.press("Escape")
        live.until(lambda: live.now("user1.held") == 0.0, "an open hand")
        page.keyboard.down("ArrowRight")
        since = live.count
        live.pass_by(10)
        assert not live.series("user1.held", since).any()


def test_handle_whose_place_is_unknown_is_not_offered(visit):
    silent = {"user1"}
    with served(WALL, silent=silent) as live:
        page = visit(live.address, silent=len(silent))
        card = page.locator("[data-user=user1]")
        expect(card.locator(".state")).to_contain_text("no data")
        expect(card.locator("button")).to_be_hidden()
        assert page.evaluate(HANDLE, 0) is None
        page.locator("#scene").focus()
        page.keyboard.press("Space")  # takes the first free handle of which the place is known
        live.until(lambda: live.now("user2.held") == 1.0, "a closed hand")
        assert not live.series("user1.held").any()
        assert "NaN" not in page.inner_text("body") and "undefined" not in page.inner_text("body")
        silent.clear()
        card.locator("button").click()
        live.until(lambda: live.now("user1.held") == 1.0, "the other hand closed")
        assert np.isfinite(page.evaluate(HANDLE, 0)["x"])


def test_gamepad_moves_hand_and_rumbles_with_force(visit):
    with served(WALL, users=1) as live:
        page = visit(live.address, script=FAKE_GAMEPAD)
        start_m = live.now("user1.x_m")
        page.evaluate("pad.axes[0] = 1")
        live.pass_by(10)
        assert live.now("user1.x_m") == start_m  # the button holds, not the stick
        page.evaluate("pad.buttons[0].pressed = true")
        live.until(lambda: _pressed(live), "a force at the wall")
        strongest = "Math.max(0, ...pad.rumbles.map((each) => each.strongMagnitude))"
        live.until(lambda: page.evaluate(strongest) > 0.05, "a rumble")
        page.evaluate("pad.buttons[0].pressed = false")
        live.until(lambda: live.now("user1.held") == 0.0, "an open hand")


@pytest.mark.parametrize("how", ["busy", "stopped", "hidden"])
def test_page_that_goes_silent_lets_go(visit, how):
    with served([*WALL, SLOW_SLEW], users=1) as live:
        page = visit(live.address)
        pointer = Pointer(page)
        pointer.press()
        pointer.move(0.03)
        live.until(lambda: _pressed(live), "a force at the wall")
        since = live.count
        opened = lambda: np.any(live.series("user1.held", since) == 0.0)  # noqa: E731
        if how == "hidden":
            page.evaluate(HIDE)
            live.until(opened, "an open hand")
            live.until(lambda: abs(live.now("user1.f_applied")) < 0.1, "no force")
        else:  # the script goes on in the end, and so does the pointer that is still pressed
            with _still(page, how):
                live.until(opened, "an open hand")
            live.until(lambda: _pressed(live), "a hand that takes hold again")
        steps = np.abs(np.diff(live.forces("user1")))
        assert 0.0 < steps.max() <= SLOW_N_PER_TICK * (1.0 + 1e-9)


def test_drag_with_three_axes_moves_in_plane_of_screen(visit):
    free = ["operator.kind=remote", "task.kind=free"]
    with served(free, users=1, name="cube_3d") as live:
        page = visit(live.address)
        axes = [live.session.layout.slices["user1.x_m"].start + axis for axis in range(3)]
        place = lambda: live.session.shown[-1].row[axes]  # noqa: E731
        start = place()
        pointer = Pointer(page)
        pointer.press()
        pointer.move(-0.03, up_m=0.03)
        live.until(lambda: place()[2] > start[2] + 0.01, "a handle higher up")
        moved = place() - start
        # Seen from the front right (yaw 0.35 rad) and above (pitch 0.4 rad): right and up.
        right, up = np.array([0.939, 0.343, 0.0]), np.array([-0.134, 0.366, 0.921])
        away = np.cross(right, up)
        assert moved @ right < -0.005 and moved @ up > 0.005
        assert abs(moved @ away) < 0.1 * np.linalg.norm(moved)
        expect(page.locator("[data-user=user1] .price")).to_contain_text("mm from its avatar")
