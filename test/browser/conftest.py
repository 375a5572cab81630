# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Pages in the machine's own Chromium, driven by playwright."""

import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

PATIENCE_MS = 60_000  # a machine that stalls is not judged here
expect.set_options(timeout=PATIENCE_MS)
NAMES = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    """Return a browser for the tests of a file; without one on this machine they are skipped.

    It ends with the file: while it is open, no other event loop can run in this process.
    """
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no Chromium on this machine (looked for {', '.join(NAMES)})")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def visit(chromium: Browser) -> Iterator[Callable[..., Page]]:
    """Return a function that opens an address in a browser of its own and waits for the picture
    of every user, or of all but some from which nothing comes.

    What the page reports as an error fails the test.
    """
    contexts, errors = [], []

    def opened(
        address: str, *, script: str = "", shown: bool = True, silent: int = 0, **options: Any
    ) -> Page:
        options.setdefault("viewport", {"width": 1000, "height": 760})
        context = chromium.new_context(**options)
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        if script:
            context.add_init_script(script)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        if shown:
            page.locator("#connection[data-state=open]").wait_for()
            users = page.locator(".user").count() - silent
            page.locator(f"#scene[data-users='{users}']").wait_for()
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not errors
