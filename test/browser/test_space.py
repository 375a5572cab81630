# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page in three dimensions: bodies where their poses are, the camera, the hand in depth, and
outlines where there is no WebGL.
"""

import io
import math

import numpy as np
import pytest
from PIL import Image
from support.page_server import served
from support.pages import HANDLE, Pointer, complaints_of

POSES = """() => Object.fromEntries([...document.getElementById("space").bodies].map(
  ([name, { position: p, quaternion: q }]) => [name, [...p, q[3], q[0], q[1], q[2]]]))"""
NO_WEBGL = """
const given = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : given.call(this, kind, ...rest);
};"""
ALONE = "() => { document.getElementById('scene').style.visibility = 'hidden'; }"
VOLUME = """(shape) => import("/solids.js").then(({ solid }) => {
  const { position: p, normal: n, index } = solid(shape);
  let volume = 0, outward = true;
  for (let i = 0; i < index.length; i += 3) {
    const corners = index.slice(i, i + 3).map((each) => 3 * each);
    const [a, b, c] = corners.map((k) => p.slice(k, k + 3));
    const across = [0, 1, 2].map((k) => {
      const [x, y] = [(k + 1) % 3, (k + 2) % 3];
      return (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
    });
    volume += across.reduce((sum, each, k) => sum + each * a[k], 0) / 6;
    for (const k of corners) {
      const along = across.reduce((sum, each, j) => sum + each * n[k + j], 0);
      if (along < -1e-12) outward = false;
    }
  }
  return { volume, outward };
})"""
DRAWN = """() => {
  const canvas = document.getElementById("scene"), { width, height } = canvas;
  return canvas.getContext("2d").getImageData(width / 2, 0.72 * height, 1, 1).data[3];
}"""  # in the middle of the body
FREE = ["operator.kind=remote", "task.kind=free"]
A, B, C = 0.03, 0.02, 0.05
SOLIDS = [
    ("box", [A, B, C], 8.0 * A * B * C),
    ("sphere", [A, 0, 0], 4.0 / 3.0 * math.pi * A**3),
    ("capsule", [B, C, 0], math.pi * B**2 * (4.0 / 3.0 * B + 2.0 * C)),
    ("cylinder", [B, C, 0], 2.0 * math.pi * B**2 * C),
    ("ellipsoid", [A, B, C], 4.0 / 3.0 * math.pi * A * B * C),
    ("mesh", [A, B, C], A * B * C / 6.0),
]
MESH = {
    "points": [[0, 0, 0], [A, 0, 0], [0, B, 0], [0, 0, C]],
    "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}


@pytest.mark.parametrize(("kind", "size", "volume"), SOLIDS, ids=[kind for kind, *_ in SOLIDS])
def test_shape_has_its_volume_and_normals_that_point_out_of_it(anything, kind, size, volume):
    """By the divergence theorem, over its triangles; 24 corners around a circle."""
    found = anything.evaluate(VOLUME, {"kind": kind, "size": size, **MESH})
    assert found["volume"] == pytest.approx(volume, rel=0.035) and found["outward"]
    assert found["volume"] <= volume * (1.0 + 1e-9)  # corners lie on what is round


def test_bodies_stand_where_their_poses_are_and_others_do_not_move(visit):
    pytest.importorskip("mujoco")
    with served(name="lift") as live:
        requests, page = [], visit("about:blank", shown=False)
        complaints = complaints_of(page)
        page.on("request", lambda request: requests.append(request.url))
        page.goto(live.address)
        page.locator("#scene[data-users='2']").wait_for()
        scene = live.session.message({})["scene"]
        first = page.evaluate(POSES)
        assert set(first) == {shape["body"] for shape in scene["shapes"]}
        moving = set(first) - set(scene["fixed"])
        assert moving == {"box", "pmwvc_user1", "pmwvc_user2"}
        live.until(lambda: live.now("box.pose") != 0.0, "a grip")
        live.until(lambda: page.evaluate(POSES)["box"][2] > 0.02, "a box that is lifted")
        page.locator("#pause").click()
        live.until(lambda: live.session.paused, "a pause")
        row, slices = live.session.shown[-1].row, live.session.layout.slices
        wanted = np.array([row[slices[f"{body}.pose"]] for body in moving])

        def shown():
            found = page.evaluate(POSES)
            return np.allclose([found[body] for body in moving], wanted, rtol=0.0, atol=1e-7)

        live.until(shown, "the poses of the newest row")
        assert page.evaluate(POSES)["world"] == first["world"] == [0, 0, 0, 1, 0, 0, 0]
        assert {url.split("/")[2] for url in requests if url != "about:blank"} == {
            live.address.split("/")[2]
        }
        assert complaints == []


def test_session_without_a_scene_has_its_cube_and_a_finger_per_user(visit):
    with served(FREE, name="cube_3d") as live:
        page = visit(live.address)
        poses = page.evaluate(POSES)
        assert set(poses) == {"object", "user1", "user2"}
        finger_m = 0.008
        for user, side in (("user1", -1), ("user2", 1)):
            x_s = live.now(f"{user}.x_s")
            assert poses[user][0] == pytest.approx(x_s + side * finger_m, abs=1e-6)
        page.evaluate(ALONE)
        picture = Image.open(io.BytesIO(page.locator("#space").screenshot())).convert("RGB")
        red, green, blue = np.asarray(picture, dtype=int).reshape(-1, 3).T
        assert ((blue > red + 60) & (blue > green + 30)).sum() > 40  # the first user's finger
        assert ((red > blue + 60) & (red > green + 30)).sum() > 40  # the second user's


def test_wheel_zooms_or_moves_a_held_handle_to_and_fro_and_the_right_button_turns_the_view(visit):
    with served(FREE, users=1, name="cube_3d") as live:
        page = visit(live.address)
        axes = [live.session.layout.slices["user1.x_m"].start + axis for axis in range(3)]
        place = lambda: live.session.shown[-1].row[axes]  # noqa: E731
        start, scale = place(), page.evaluate(HANDLE, 0)["scale"]
        page.mouse.move(300, 300)
        page.mouse.wheel(0, -300)
        live.until(lambda: page.evaluate(HANDLE, 0)["scale"] > 1.3 * scale, "a nearer view")
        assert np.allclose(place(), start, atol=1e-6)
        pointer = Pointer(page)
        pointer.press()
        live.until(lambda: live.now("user1.held") == 1.0, "a closed hand")
        page.mouse.wheel(0, -400)  # away, by 20 mm
        live.until(lambda: np.linalg.norm(place() - start) > 0.015, "a handle farther away")
        moved = place() - start
        away = np.array([-0.316, 0.865, -0.389])  # yaw 0.35 rad, pitch 0.4 rad
        assert moved @ away > 0.95 * np.linalg.norm(moved)
        pointer.release()
        live.until(lambda: live.now("user1.held") == 0.0, "an open hand")
        before, since = Pointer(page), live.count
        page.mouse.move(before.x, before.y)  # on the handle itself
        page.mouse.down(button="right")
        page.mouse.move(before.x + 150, before.y, steps=5)
        page.mouse.up(button="right")
        live.until(lambda: abs(Pointer(page).x - before.x) > 10, "another view")
        assert not live.series("user1.held", since).any()


def test_shift_turns_a_handle_of_six_axes_to_where_its_near_side_is_dragged(visit):
    with served(["dof=6"], users=1) as live:
        page = visit(live.address)
        axes = [live.session.layout.slices["user1.x_m"].start + axis for axis in range(6)]
        place = lambda: live.session.shown[-1].row[axes]  # noqa: E731
        start, pointer = place(), Pointer(page)
        pointer.press()
        live.until(lambda: live.now("user1.held") == 1.0, "a closed hand")
        page.keyboard.down("Shift")
        pointer.move(0.02)
        live.until(lambda: np.linalg.norm((place() - start)[3:]) > 0.01, "a turn")
        moved = place() - start
        assert np.linalg.norm(moved[:3]) < 0.1 * np.linalg.norm(moved[3:])
        near, right = np.array([0.316, -0.865, 0.389]), np.array([0.939, 0.343, 0.0])
        assert np.cross(moved[3:], near) @ right > 0.95 * np.linalg.norm(moved[3:])


def test_two_fingers_turn_and_zoom_and_a_second_one_moves_a_held_handle_to_and_fro(visit):
    with served(FREE, users=1, name="cube_3d") as live:
        page = visit(live.address, has_touch=True)
        box, handle = page.locator("#scene").bounding_box(), page.evaluate(HANDLE, 0)
        devtools = page.context.new_cdp_session(page)

        def touch(kind, *points):
            at = [{"x": box["x"] + x, "y": box["y"] + y, "id": i} for i, (x, y) in points]
            devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

        low = box["height"] - 40
        touch("touchStart", (0, (60, low)), (1, (120, low)))
        for step in range(1, 11):
            touch("touchMove", (0, (60 - 3 * step, low)), (1, (120 + 3 * step, low)))
        touch("touchEnd")
        nearer = lambda: page.evaluate(HANDLE, 0)["scale"] > 1.5 * handle["scale"]  # noqa: E731
        live.until(nearer, "a nearer view")
        assert not live.series("user1.held").any()
        handle, start = page.evaluate(HANDLE, 0), live.now("user1.x_m")
        axes = [live.session.layout.slices["user1.x_m"].start + axis for axis in range(3)]
        start = live.session.shown[-1].row[axes]
        on = (0, (handle["x"], handle["y"]))
        touch("touchStart", on)
        live.until(lambda: live.now("user1.held") == 1.0, "a closed hand")
        touch("touchStart", on, (1, (60, low)))
        for step in range(1, 11):
            touch("touchMove", on, (1, (60, low - 8 * step)))
        gone = lambda: live.session.shown[-1].row[axes] - start  # noqa: E731
        live.until(lambda: gone()[1] > 0.01, "a handle farther away")
        touch("touchEnd")
        live.until(lambda: live.now("user1.held") == 0.0, "an open hand")


def test_without_webgl_outlines_are_drawn_and_the_handle_is_held_all_the_same(visit):
    pytest.importorskip("mujoco")
    with served(["operator.kind=remote"], name="lift") as live:
        page = visit(live.address, script=NO_WEBGL)
        assert page.locator("#space").is_hidden()
        assert page.evaluate("!document.body.hasAttribute('data-space')")
        assert page.evaluate(DRAWN) == 255
        pointer = Pointer(page)
        pointer.press()
        pointer.move(-0.01)
        live.until(lambda: live.now("user1.held") == 1.0, "a closed hand")


def test_picture_goes_on_in_outlines_when_webgl_is_lost(visit):
    with served(FREE, name="cube_3d") as live:
        page = visit(live.address)
        assert page.locator("#space").is_visible()
        lost = "document.getElementById('space').getContext('webgl2')"
        page.evaluate(f"{lost}.getExtension('WEBGL_lose_context').loseContext()")
        page.locator("#space").wait_for(state="hidden")
        assert page.evaluate(DRAWN) == 255
