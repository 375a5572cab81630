# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures a second of the page in this machine's Chromium: of one axis, and of scenes of three by
their number of bodies. Time stands still meanwhile, so the simulation takes no part of a core.
"""

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright
from rich.table import Table
from support.page_server import served

BODIES = (10, 60)
KINDS = {
    "box": "0.02 0.02 0.02", "sphere": "0.02", "capsule": "0.012 0.015", "cylinder": "0.015 0.02",
}  # fmt: skip
BODY = '<body pos="{} {} 0"><freejoint/><geom type="{}" size="{}" mass="0.05"/></body>'
SCENE = (
    '<mujoco><worldbody><geom type="plane" size="0 0 1" pos="0 0 -0.1"/>{}</worldbody></mujoco>'
)
COUNTED = """(length_ms) => new Promise((resolve) => {
  const begin = performance.now();
  let count = 0;
  const next = () => {
    count += 1;
    if (performance.now() - begin < length_ms) requestAnimationFrame(next);
    else resolve((1e3 * count) / (performance.now() - begin));
  };
  requestAnimationFrame(next);
})"""
BY = """() => {
  const gl = document.getElementById("space").getContext("webgl2");
  const known = gl && gl.getExtension("WEBGL_debug_renderer_info");
  return known ? gl.getParameter(known.UNMASKED_RENDERER_WEBGL) : "no WebGL";
}"""


def scene_of(bodies, folder):
    """Write a scene of so many bodies on a floor; return its file."""
    places = [(0.07 * (n % 8 - 3.5), 0.07 * (n // 8 - 3.5)) for n in range(bodies)]
    kinds = list(KINDS.items())
    text = "".join(BODY.format(*at, *kinds[n % len(kinds)]) for n, at in enumerate(places))
    file = Path(folder) / f"{bodies}.xml"
    file.write_text(SCENE.format(text), "utf-8")
    return file


def bench_frames(length_s=3.0):
    """Return a table and the numbers behind it."""
    path, numbers = shutil.which("chromium") or shutil.which("google-chrome"), {}
    table = Table("scene", "pictures a second")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        of = {"one axis": ("live", [])}
        for bodies in BODIES:
            scene = f"server.scene={scene_of(bodies, folder)}"
            of[f"{bodies} bodies"] = ("lift", [scene, "server.settle=true"])
        for what, (name, settings) in of.items():
            with served(settings, name=name) as live:
                page = browser.new_page(viewport={"width": 1000, "height": 760})
                page.goto(live.address)
                page.locator("#scene[data-users='2']").wait_for()
                page.locator("#pause").click()
                live.until(lambda live=live: live.session.paused, "a pause")
                numbers[what] = page.evaluate(COUNTED, 1e3 * length_s)
                table.add_row(what, f"{numbers[what]:.0f}")
                table.caption = f"drawn by {page.evaluate(BY)}"
                page.close()
        browser.close()
    return table, numbers | {"by": table.caption}
