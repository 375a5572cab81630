# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The gestures of a person at the page."""

from typing import Any

from playwright.sync_api import Page

HANDLE = "(user) => document.getElementById('scene').handles.find((each) => each.user === user)"


def complaints_of(page: Page) -> list[str]:
    """Return what a page writes to its console from now on, but how fast the driver is."""
    found: list[str] = []
    own = lambda text: "GL Driver Message (OpenGL, Performance" not in text  # noqa: E731
    page.on("console", lambda said: found.append(said.text) if own(said.text) else None)
    return found


class Pointer:
    """A mouse or a finger on a user's handle; distances in metres in the plane of the screen."""

    def __init__(self, page: Page, user: int = 0, *, touch: bool = False) -> None:
        self._page, self._touch = page, touch
        box = page.locator("#scene").bounding_box()
        handle = page.evaluate(HANDLE, user)
        assert box is not None and handle is not None
        self._scale = handle["scale"]
        self._x, self._y = box["x"] + handle["x"], box["y"] + handle["y"]
        self._devtools = page.context.new_cdp_session(page) if touch else None

    def _send(self, kind: str, points: list[dict[str, Any]]) -> None:
        assert self._devtools is not None
        message = {"type": kind, "touchPoints": points}
        self._devtools.send("Input.dispatchTouchEvent", message)

    def press(self) -> None:
        """Put the pointer on the handle and press."""
        if self._touch:
            self._send("touchStart", [{"x": self._x, "y": self._y}])
            return
        self._page.mouse.move(self._x, self._y)
        self._page.mouse.down()

    def move(self, distance_m: float, up_m: float = 0.0, steps: int = 10) -> None:
        """Move on to the right, and up, in small steps."""
        for _ in range(steps):
            self._x += distance_m * self._scale / steps
            self._y -= up_m * self._scale / steps
            if self._touch:
                self._send("touchMove", [{"x": self._x, "y": self._y}])
            else:
                self._page.mouse.move(self._x, self._y)

    def release(self) -> None:
        """Let go."""
        if self._touch:
            self._send("touchEnd", [])
        else:
            self._page.mouse.up()
