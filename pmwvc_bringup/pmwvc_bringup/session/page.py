# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a session: served in this process, or by the view node of a session that somebody
else started, in the domain of that session.
"""

import os
import re
import subprocess
import sys
import webbrowser

from rich.console import Console

from pmwvc_bringup.session.plan import MODULES, Page
from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment, running_domains
from pmwvc_core.errors import PmwvcError
from pmwvc_core.runtime.interrupts import Interrupts, held_back
from pmwvc_view import SNAPSHOT_S
from pmwvc_view.session import Session
from pmwvc_view.web.access import new_token, why_refused
from pmwvc_view.web.server import PageServer

DOMAIN = "ROS_DOMAIN_ID"


def serve(session: Session, console: Console, *, page: Page, browser: bool) -> None:
    """Serve a session until interrupted; PmwvcError where the address cannot be listened on."""
    require_address(page)
    server = PageServer(
        session, host=page.host, port=page.port, token=new_token(), snapshot_s=SNAPSHOT_S
    )
    with Interrupts().caught() as interrupts:
        server.run(interrupts, lambda: show(server.address, console, browser=browser))


def require_address(page: Page) -> None:
    """Raise a PmwvcError where no page can be served at an address."""
    if why := why_refused(page.host, page.port):
        raise PmwvcError(f"--host {page.host} --port {page.port}: {why}")


def address_in(output: str) -> str | None:
    """Return the address that a view node has printed as a line of its output, or None."""
    found = re.search(r"^page (.*)$", output, re.MULTILINE)
    return found[1] if found else None


def show(address: str, console: Console, *, browser: bool) -> None:
    """Print the address of a page, and open it where there is a desktop."""
    console.print(f"page: {address}", markup=False, soft_wrap=True, highlight=False)
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if browser and (shown or sys.platform in ("darwin", "win32")):
        webbrowser.open(address)


def join(console: Console, *, page: Page, namespace: str, browser: bool) -> int:
    """Run the view node until it ends or the user interrupts; return its exit code. PmwvcError
    where several sessions run on this machine and none is chosen, and where the address cannot be
    listened on.
    """
    require_address(page)
    environment = own_environment({RANGE: LOCALHOST, **os.environ})
    if not environment.get(DOMAIN):
        domains = running_domains()
        if len(domains) > 1:
            texts = ", ".join(f"{DOMAIN}={domain}" for domain in domains)
            raise PmwvcError(f"several sessions run on this machine: choose one by {texts}")
        environment[DOMAIN] = str(domains[0] if domains else 0)
    words = [sys.executable, "-m", MODULES["view"], "--ros-args"]
    words += ["-p", f"host:={page.host}", "-p", f"port:={page.port}"]
    if namespace:
        words += ["-r", f"__ns:=/{namespace.strip('/')}"]
    console.print(f"looking for a session with {DOMAIN}={environment[DOMAIN]}; Ctrl-C ends")
    with Interrupts().caught():  # the node gets a Ctrl-C as well, and ends by it
        with held_back():  # for the node, until it can end by it
            process = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        with process.stdout as lines:
            for line in lines:
                if address := address_in(line):
                    show(address, console, browser=browser)
        return process.wait()
