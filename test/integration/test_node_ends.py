# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A node that ROS does not let end: its work is closed, it ends by itself, the log says why."""

import os
import signal
import subprocess
import sys

import pytest

from pmwvc_bringup.session.surroundings import own_domain

pytestmark = pytest.mark.integration
# Both threads print: a line is one write, or one may end up within the other.
NODE = """
import sys, threading
from pmwvc_core.runtime.process import run_node

class Work:
    def __init__(self, node):
        {setup}

    def run(self, stop):
        print("running\\n", end="", flush=True)
        stop.wait()

    def close(self):
        print("released", flush=True)

sys.exit(run_node("stuck", Work, args=[]))
"""
HANGS = {
    "ROS did not remove the node": "node.destroy_node = threading.Event().wait",
    "a service did not return": (
        "hang = threading.Event().wait; "
        "node.create_timer(0.001, lambda: (print('busy\\n', end='', flush=True), hang()))"
    ),
}


@pytest.mark.parametrize("text", HANGS)
def test_a_node_that_cannot_end_releases_its_device_and_states_where_it_hangs(text):
    with own_domain(os.environ) as domain:
        process = subprocess.Popen(
            [sys.executable, "-c", NODE.format(setup=HANGS[text])],
            env=dict(os.environ, ROS_DOMAIN_ID=str(domain)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        lines = [process.stdout.readline()]
        if "service" in text:
            while "busy\n" not in lines or "running\n" not in lines:
                lines.append(process.stdout.readline())
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate()
    assert said.endswith("released\n")
    assert process.returncode == 0
    assert text in errors
    assert "most recent call first" in errors  # where every thread stands
