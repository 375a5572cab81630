# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The view of a session that somebody else started: its node in a process of its own, in the
domain of the session.
"""

import os
import subprocess
import sys

from rich.console import Console

from pmwvc_bringup.session.page import address_in, show
from pmwvc_bringup.session.plan import MODULES, Page
from pmwvc_bringup.session.processes import Interrupts
from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment, running_domains
from pmwvc_core.errors import PmwvcError

DOMAIN = "ROS_DOMAIN_ID"


def view(console: Console, *, page: Page, namespace: str, browser: bool) -> int:
    """Run the view node until it ends or the user interrupts; return its exit code. PmwvcError
    where several sessions run on this machine and none is chosen.
    """
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
        process = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        with process.stdout as lines:
            for line in lines:
                if address := address_in(line):
                    show(address, console, browser=browser)
        return process.wait()
