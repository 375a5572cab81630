# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The end of a node: with whoever launched it; and by itself where ROS does not let it end, with
its work closed and the reason in the log.
"""

import os
import signal
import subprocess
import sys

import pytest

from pmwvc_bringup.session.processes import ENDS_WITH_PARENT
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

LAUNCHER = "import subprocess, sys; subprocess.run(sys.argv[1:])"


def test_a_launched_node_ends_whole_when_its_launcher_is_gone():
    node = [sys.executable, "-c", NODE.format(setup="pass")]
    with own_domain(os.environ) as domain:
        launcher = subprocess.Popen(
            [sys.executable, "-c", LAUNCHER, *ENDS_WITH_PARENT.split(), *node],
            env=dict(os.environ, ROS_DOMAIN_ID=str(domain)),
            stdout=subprocess.PIPE,
            text=True,
        )
        assert launcher.stdout.readline() == "running\n"
        launcher.kill()
        assert launcher.communicate()[0] == "released\n"  # the node had the same pipe


@pytest.fixture(scope="module")
def hung():
    """What nodes that hang said until they ended, all at once: each waits for its time to be over;
    by the reason: standard output, errors, exit code.
    """
    found, processes = {}, {}
    with own_domain(os.environ) as domain:
        for text, setup in HANGS.items():
            processes[text] = subprocess.Popen(
                [sys.executable, "-c", NODE.format(setup=setup)],
                env=dict(os.environ, ROS_DOMAIN_ID=str(domain)),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        for text, process in processes.items():
            lines = [process.stdout.readline()]
            if "service" in text:
                while "busy\n" not in lines or "running\n" not in lines:
                    lines.append(process.stdout.readline())
            process.send_signal(signal.SIGINT)
        for text, process in processes.items():
            found[text] = (*process.communicate(), process.returncode)
    return found


@pytest.mark.parametrize("text", HANGS)
def test_a_node_that_cannot_end_releases_its_device_and_states_where_it_hangs(hung, text):
    said, errors, code = hung[text]
    assert said.endswith("released\n")
    assert code == 0
    assert text in errors
    assert "most recent call first" in errors  # where every thread stands
