# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands of the README on three machines that no multicast connects, of which one has a
monotonic clock of its own.
"""

import json
import os
import re
import shlex
import signal
from contextlib import ExitStack

import pytest
from support.namespaces import NotAllowed, machines
from support.processes import Program
from support.sessions import ROOT

pytestmark = pytest.mark.integration
HEADING = "## One node per user, on several machines"
LINE = re.compile(r"^ *(every machine|no multicast|server machine|user 1|user 2): +(\S.*)$", re.M)
PROBE = """
import socket, sys
here, group, port = sys.argv[1], "239.255.0.1", 17900
inlet = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
inlet.bind(("", port))
membership = socket.inet_aton(group) + socket.inet_aton(here)
inlet.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
print("listening", flush=True)
print("got", inlet.recv(9).decode(), flush=True)
"""
SEND = """
import socket, sys
here, there = sys.argv[1:]
outlet = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
outlet.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(here))
outlet.sendto(b"multicast", ("239.255.0.1", 17900))
outlet.sendto(b"unicast", (there, 17900))
"""


def commands():
    """Return where and what the README's section runs, in its order."""
    text = (ROOT / "README.md").read_text("utf-8")
    section = text[text.index(HEADING) :].split("\n## ")[0]
    block = section.split("```")[1]
    found = LINE.findall(block)
    assert len(found) == len(block.strip().splitlines())
    return found


@pytest.fixture
def three():
    """The server's machine and those of two users, at the addresses that the README names."""
    addresses = re.findall(r"\d+\.\d+\.\d+\.\d+", dict(commands())["no multicast"])
    with ExitStack() as stack:
        try:
            found = stack.enter_context(machines(addresses))
        except NotAllowed as reason:
            pytest.skip(f"no network namespaces here: {reason}")
        yield dict(zip(("server machine", "user 1", "user 2"), found, strict=True))


def test_the_readme_connects_three_machines_without_multicast(three, tmp_path):
    server, user = three["server machine"], three["user 1"]
    python = f"{ROOT}/.venv/bin/python"
    with Program([*server.into, python, "-c", PROBE, server.address]) as probe:
        probe.await_output("listening")
        user.run(python, "-c", SEND, user.address, server.address)
        assert probe.await_output("got") == "got unicast"  # the multicast before it did not pass
    ahead_s = three["user 2"].set_clock_ahead(3600)
    clean = {k: v for k, v in os.environ.items() if not re.match("ROS_|FASTDDS|FASTRTPS", k)}
    clean |= {"ROS_LOG_DIR": str(tmp_path / "log"), "PYTHONUNBUFFERED": "1"}
    folder = tmp_path / "session"
    programs = {}
    with ExitStack() as stack:
        for machine, text in commands():
            command = text.replace("./pmwvc", str(ROOT / "pmwvc"))
            command = command.replace("/tmp/session", str(folder))
            if command.startswith("export "):
                values = [word.partition("=") for word in shlex.split(command)[1:]]
                clean |= {name: value for name, _, value in values}
                continue
            words = [*three[machine].into, "sh", "-c", f"exec {command}"]
            name = " ".join([machine, *shlex.split(text)[1:3]])
            if "pmwvc report" in text:
                _until_recorded(programs, folder)
            program = Program(words, environment=clean, folder=tmp_path)
            programs[name] = stack.enter_context(program)
            if " node " not in text:
                assert program.wait() == 0, program.output
    summary = json.loads((folder / "summary.json").read_text("utf-8"))
    assert [each["name"] for each in summary["users"]] == ["user1", "user2"]
    # Not judged is what the recorder missed before it had found everybody.
    passives = [each["passive"] for each in summary["users"]]
    assert False not in passives, summary["passivity"]["text"]
    received = {each["name"]: each for each in summary["receptions"]}
    assert set(received) == {"user1/up", "user1/down", "user2/up", "user2/down"}
    for name, each in received.items():
        assert each["counts"]["accepted"] > 100
        assert not any(each["counts"][name] for name in ("forged", "other_session", "corrupted"))
        path, sign = each["path"], {"user2/up": 1, "user2/down": -1}.get(name, 0)
        assert abs(path["offset"] - sign * ahead_s) <= path["delay_open"]
        assert (path["delay_open"] == 0.0) == (sign * ahead_s == 0.0)
        assert abs(path["drift"]) <= path["drift_open"]  # the machines have one crystal
        assert path["round_trip"] > 0.008  # of the emulated link


def _until_recorded(programs, folder):
    """Wait until both users are coupled and some seconds are on record; end the nodes in order."""
    server = programs["server machine node server"]
    for user in ("user1", "user2"):
        server.await_output(f"{user} is coupled")
    recorder = programs["server machine node recorder"]
    file = folder / "session.mcap"
    recorder.until(lambda: file.is_file() and file.stat().st_size > 400_000)
    for kind in ("node master", "node server", "node netem", "node recorder"):
        for name, program in programs.items():
            if name.endswith(kind):
                assert program.stop(signal.SIGINT) == 0, program.output
