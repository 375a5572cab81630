# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Pages in the machine's own Chromium, driven by playwright."""

import contextlib
import functools
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright
from support.page_server import served

PATIENCE_MS = 60_000  # a machine that stalls is not judged here
expect.set_options(timeout=PATIENCE_MS)
NAMES = ("chromium", "chromium-browser", "google-chrome")


ENDS = contextlib.ExitStack()


@functools.cache
def browser() -> Browser:
    """Return one browser for all tests of this folder; without one they are skipped."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no Chromium on this machine (looked for {', '.join(NAMES)})")
    ENDS.callback(browser.cache_clear)
    playwright = ENDS.enter_context(sync_playwright())
    made = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
    ENDS.callback(made.close)
    return made


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> None:
    """End the browser with the folder: beside it no other event loop can run in this process."""
    if nextitem is None or Path(__file__).parent not in nextitem.path.parents:
        ENDS.close()


@pytest.fixture(scope="module")
def anything() -> Iterator[Page]:
    """Return a page of any session, to ask what its modules do."""
    with served(users=1) as live:
        page = browser().new_page()
        page.goto(live.address)
        yield page
        page.close()


@pytest.fixture
def visit() -> Iterator[Callable[..., Page]]:
    """Return a function that opens an address in a browser of its own and waits for the picture
    of every user, or of all but some from which nothing comes.

    What the page reports as an error fails the test.
    """
    contexts, errors = [], []

    def opened(
        address: str, *, script: str = "", shown: bool = True, silent: int = 0, **options: Any
    ) -> Page:
        options.setdefault("viewport", {"width": 1000, "height": 760})
        context = browser().new_context(**options)
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
