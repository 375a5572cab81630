# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wheel of the tree works in an environment that has nothing but what the wheel declares."""

import json
import os
import re
import subprocess
import sys
import urllib.request
import zipfile
from email import message_from_bytes
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from rosbags.highlevel import AnyReader
from setup_ros import locked
from support.other_systems import ENCODING, GONE, taken_away

from pmwvc_analysis.recording.schemas import OUR_TYPES, schema_text, store_of

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.prefix, "bin")


def run(*words, cwd, code=0, encoding=None, **environment):
    """Run a program without this environment's variables; return what it printed."""
    keep = {name: os.environ[name] for name in ("HOME", "LANG") if name in os.environ}
    result = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env={"PATH": os.defpath} | keep | environment,
        capture_output=True,
        text=True,
        encoding=encoding,
    )
    assert result.returncode == code, result.stdout + result.stderr
    return result.stdout + result.stderr


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """A virtual environment with the wheel and its declared dependencies, and nothing else.

    The dependencies have the locked versions, from the cache that the set-up filled.
    """
    folder = tmp_path_factory.mktemp("fresh")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=ROOT)
    (wheel,) = folder.glob("*.whl")
    file = folder / "requirements.txt"
    file.write_text("".join(locked(name) for name in sorted(required(wheel))), "utf-8")
    uv, cache = BIN / "uv", cache_of_the_setup()
    run(uv, "venv", "-q", "--python", sys.executable, folder / "env", cwd=folder, **cache)
    install = [uv, "pip", "install", "-q", "--python", folder / "env/bin/python", "--no-deps"]
    packages = [*install, "--require-hashes", "--system-certs", "-r", file]
    try:
        run(*packages, "--offline", cwd=folder, **cache)
    except AssertionError:  # the set-up took another installer: from the registry, as a user would
        run(*packages, cwd=folder, **cache)
    run(*install, "--offline", wheel, cwd=folder, **cache)
    run(uv, "pip", "check", "--python", folder / "env/bin/python", cwd=folder, **cache)
    return folder


def required(wheel):
    """Return the names of all packages that a wheel needs, from its metadata and theirs."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [each for each in archive.namelist() if each.endswith("dist-info/METADATA")]
        metadata = message_from_bytes(archive.read(name))
    found, waiting = set(), metadata.get_all("Requires-Dist")
    while waiting:
        requirement = Requirement(waiting.pop())
        name = canonicalize_name(requirement.name)
        marker = requirement.marker
        if name not in found and (marker is None or marker.evaluate({"extra": ""})):
            found.add(name)
            waiting += requires(name) or []
    return found


def cache_of_the_setup():
    """Return the cache folder that the set-up gave uv, where that was not its own."""
    own = ROOT / ".ros" / "uv"
    folder = str(own) if own.is_dir() else os.environ.get("UV_CACHE_DIR")
    return {"UV_CACHE_DIR": folder} if folder else {}


def test_nothing_of_ros_is_installed(fresh):
    found = run(BIN / "uv", "pip", "list", "--python", fresh / "env/bin/python", cwd=fresh)
    names = {line.split()[0] for line in found.splitlines()[2:]}
    assert {"pmwvc", "numpy", "rosbags"} <= names
    assert not [name for name in names if name.startswith(("ros-", "pmwvc_", "rclpy"))]
    assert len(names) < 35


def test_the_recording_is_one_that_this_environment_reads_alike(fresh):
    """Message definitions came with the wheel: types in the file are those of the tree."""
    program = "import pmwvc; wall = pmwvc.scenario('wall', duration_s=0.2)\n"
    program += "pmwvc.record('short', pmwvc.simulate(wall), wall); print(pmwvc.stability(wall))"
    said = run(fresh / "env/bin/python", "-c", program, cwd=fresh)
    assert "'stable': True" in said
    with AnyReader([fresh / "short"]) as reader:
        found = {c.msgtype: c.msgdef.data for c in reader.connections if "pmwvc" in c.msgtype}
        assert len(list(reader.messages())) > 100
    assert set(found) == set(OUR_TYPES)
    for name, text in found.items():
        theirs, ours = store_of((text, name)), store_of((schema_text(name), name))
        assert theirs.hash_rihs01(name) == ours.hash_rihs01(name)


@pytest.fixture(params=["Linux", "Darwin", "Windows"])
def system(request, tmp_path):
    """Environment variables that make Python one of a system, by what is not there."""
    return {} if request.param == "Linux" else taken_away(request.param, tmp_path / "gone")


def test_the_page_of_a_simulated_session_is_served(fresh, system):
    words = [fresh / "env/bin/pmwvc", "view", "wall", "--no-browser"]
    own = {"PATH": os.defpath, "HOME": os.environ["HOME"], "PYTHONUNBUFFERED": "1"}
    environment = own | system
    view = subprocess.Popen(words, cwd=fresh, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        address = next(m[0] for line in view.stdout if (m := re.search(r"http://\S+", line)))
        with urllib.request.urlopen(address) as page:
            assert b"<canvas" in page.read()
    finally:
        view.kill()
        view.wait()
        view.stdout.close()


COMMANDS = {  # and what they say
    ("doctor",): "",
    ("scenarios", "three_users"): "",
    ("links", "carry_16ms"): "",
    ("token", "keys", "user1", "user2"): "",
    ("simulate", "wall", "--duration", "2", "--out", "one", "--check", "--no-figures"): "passed",
    ("report", "one", "--json"): '"stable": true',
    ("doctor", "one"): "complete",
    ("export", "one", "--as", "csv"): "",
    ("export", "one", "--as", "mat"): "session.mat",
    ("replay", "one", "--out", "again", "--no-figures"): "",
    ("compare", "wall", "--over", "link.delay_s=0,0.01", "--duration", "0.5", "--no-figures"): "",
    ("stability", "wall"): "",
    ("transparency", "wall"): "",
    ("tune", "wall", "--set", "duration_s=2", "--out", "tuned.yaml"): "",
    ("map", "wall", "--x", "master.impedance=10:30:3", "--y", "link.delay_s=0:0.01:2"): "",
}


ONE_AFTER_THE_OTHER = """
import json, sys
from pmwvc_bringup.cli import main
for words in json.loads(sys.argv[1]):
    print("ENDED", main(words), flush=True)
"""


def test_every_command_works_where_the_most_calls_are_missing(fresh, tmp_path):
    """Windows lacks all that macOS lacks. No traceback, no character that its terminal cannot
    show, no file in an encoding that depends on the machine. Nothing is compiled: that takes
    minutes, and needs no call of the system.
    """
    assert all(set(GONE["Darwin"][name]) <= set(GONE["Windows"][name]) for name in GONE["Darwin"])
    system = taken_away("Windows", tmp_path / "gone") | {"NUMBA_DISABLE_JIT": "1"}
    options = {"cwd": tmp_path, "encoding": ENCODING["Windows"], **system}
    every = json.dumps(list(COMMANDS))
    said = run(fresh / "env/bin/python", "-c", ONE_AFTER_THE_OTHER, every, **options)
    assert "Traceback" not in said
    for (words, wanted), part in zip(COMMANDS.items(), said.split("ENDED"), strict=False):
        assert wanted in part, (words, part)
    assert said.count("ENDED 0\n") == len(COMMANDS)
    assert (tmp_path / "one" / "report.html").exists()


def test_doctor_finds_nothing_wrong_in_a_sound_environment_of_pip(fresh, system, tmp_path):
    said = run(fresh / "env/bin/pmwvc", "doctor", cwd=tmp_path, **system)
    assert "problem" not in said and "bug" not in said
    assert "live sessions need" in said


@pytest.mark.parametrize("words", [("run", "wall"), ("node", "master", "--help")])
def test_a_command_that_needs_ros_says_so_in_one_sentence(fresh, words):
    told = run(fresh / "env/bin/pmwvc", *words, cwd=fresh, code=2)
    assert told.count("\n") == 1
    assert "ROS 2 is not in this Python environment" in told
