# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a session: its address, and a server for it in this process."""

import os
import sys
import webbrowser

from rich.console import Console

from pmwvc_bringup.session.plan import Page
from pmwvc_core.errors import PmwvcError
from pmwvc_core.runtime.interrupts import Interrupts
from pmwvc_view.session import Session
from pmwvc_view.web.access import new_token, why_refused
from pmwvc_view.web.server import PageServer


def serve(session: Session, console: Console, *, page: Page, browser: bool) -> None:
    """Serve a session until interrupted; PmwvcError where the address cannot be listened on."""
    require_address(page)
    server = PageServer(session, host=page.host, port=page.port, token=new_token())
    with Interrupts().caught() as interrupts:
        server.run(interrupts, lambda: show(server.address, console, browser=browser))


def require_address(page: Page) -> None:
    """Raise a PmwvcError where no page can be served at an address."""
    if why := why_refused(page.host, page.port):
        raise PmwvcError(f"--host {page.host} --port {page.port}: {why}")


def show(address: str, console: Console, *, browser: bool) -> None:
    """Print the address of a page, and open it where there is a desktop."""
    console.print(f"page: {address}", markup=False, soft_wrap=True, highlight=False)
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if browser and (shown or sys.platform in ("darwin", "win32")):
        webbrowser.open(address)
