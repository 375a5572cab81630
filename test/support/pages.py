# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The gestures of a person at the page."""

from typing import Any

from playwright.sync_api import Page

TRIES = 20
PRESSED = "'held' in document.getElementById('scene').dataset"
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
        self._page, self._user, self._touch = page, user, touch
        self._devtools = page.context.new_cdp_session(page) if touch else None
        self._find()

    def _find(self) -> None:
        """Go to where the handle is now."""
        box = self._page.locator("#scene").bounding_box()
        handle = self._page.evaluate(HANDLE, self._user)
        assert box is not None and handle is not None
        self._scale = handle["scale"]
        self.x, self.y = box["x"] + handle["x"], box["y"] + handle["y"]

    def _send(self, kind: str, points: list[dict[str, Any]]) -> None:
        assert self._devtools is not None
        message = {"type": kind, "touchPoints": points}
        self._devtools.send("Input.dispatchTouchEvent", message)

    def press(self) -> None:
        """Put the pointer on the handle and press; again where the page has just moved it, as by a
        notice above the picture.
        """
        for _ in range(TRIES):
            self._find()
            if self._touch:
                self._send("touchStart", [{"x": self.x, "y": self.y}])
            else:
                self._page.mouse.move(self.x, self.y)
                self._page.mouse.down()
            if self._page.evaluate(PRESSED):
                return
            self.release()
        raise AssertionError("the handle does not stay where it is")

    def move(self, distance_m: float, up_m: float = 0.0, steps: int = 10) -> None:
        """Move on to the right, and up, in small steps."""
        for _ in range(steps):
            self.x += distance_m * self._scale / steps
            self.y -= up_m * self._scale / steps
            if self._touch:
                self._send("touchMove", [{"x": self.x, "y": self.y}])
            else:
                self._page.mouse.move(self.x, self.y)

    def release(self) -> None:
        """Let go."""
        if self._touch:
            self._send("touchEnd", [])
        else:
            self._page.mouse.up()
