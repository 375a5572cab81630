# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of real processes: live sessions whose nodes are killed, started and stopped."""

import json
import os
import re
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from faults.fault import Fault, Outcome, joined, undisturbed
from pmwvc_analysis.prediction.lag import lag_s
from pmwvc_analysis.recording.reader import read_session
from pmwvc_bringup import scenarios
from pmwvc_core.numeric import Array
from pmwvc_core.traces import SessionTraces, UserTraces
from pmwvc_core.wave.impedance import first_axis

ROOT = Path(__file__).resolve().parents[2]
LIMIT_S = 180
PAUSE_S = 0.15  # of a loop: it stood still or was not there
STAYED_S = 0.01  # a block: who is coupled by then was never uncoupled


class Live:
    """A live session of a scenario, ended and read."""

    def __init__(self, name: str, *settings: str) -> None:
        words = [word for text in settings for word in ("--set", text)]
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "session"
            command = [str(ROOT / "pmwvc"), "run", name, *words, "--out", str(folder), "--json"]
            ran = subprocess.run(
                command, capture_output=True, text=True, timeout=LIMIT_S, check=False
            )
            if not ran.stdout.strip():
                raise RuntimeError(ran.stderr[-800:])
            self.summary = json.loads(ran.stdout)
            self.traces: SessionTraces = read_session(folder)
        self.scenario = scenarios.load(name, settings_texts=list(settings))
        self.times_s = [  # of what was done to the nodes, in its order
            float(each["time_s"])
            for each in self.summary["events"]
            if each["kind"] == "disturbance" and each["time_s"] is not None
        ]

    def damped(self, name: str, after_s: float) -> tuple[bool, str]:
        """Tell whether a user has only damping within 0.2 s of a time."""
        late_s = _first(self._user(name), after_s, 2) - after_s
        return late_s <= 0.2, f"{name} in damping after {1e3 * late_s:.0f} ms"

    def coupled(self, name: str, after_s: float, within_s: float) -> tuple[bool, str]:
        """Tell whether a user is coupled soon after the first tick of a node that goes on."""
        user, server = self._user(name), self.traces.server
        assert server is not None
        begins = [*_behind_gaps(user.block_time_s), *_behind_gaps(server.time_s)]
        runs_s = min((t for t in begins if t >= after_s), default=after_s)
        late_s = _first(user, after_s, 1)
        text = f"{name} coupled {late_s - after_s:.2f} s after the end"
        if late_s - after_s <= STAYED_S:
            text = f"{name} stayed coupled"
        elif runs_s > after_s:
            text += f", {late_s - runs_s:.2f} s after the first tick"
        return late_s - runs_s <= within_s, text

    def together(self, since_s: float) -> tuple[bool, str]:
        """Tell whether every device is close to its avatar from a time on."""
        server = self.traces.server
        assert server is not None
        rows = server.time_s >= since_s
        found, most = [], []
        for user, one in zip(self.traces.users, self.scenario.users, strict=True):
            x_s = server.x_s[server.users.index(user.name)][rows, 0]
            x_m = np.interp(server.time_s[rows], user.time_s, user.x_m[:, 0])
            force = np.abs(user.f_applied[user.time_s >= since_s, 0]).mean()
            round_s = lag_s(one, self.scenario, live=True)
            most.append(1e3 * force * round_s / (2.0 * first_axis(one.impedance)) + 1.0)
            found.append(1e3 * float(np.abs(x_m - x_s).mean()))
        after_s = since_s - self.times_s[-1]
        text = f"offset {max(found):.1f} mm from {after_s:.1f} s after the end on"
        held = all(apart <= limit for apart, limit in zip(found, most, strict=True))
        return held, f"{text} (allowed {max(most):.1f})"

    def stays(self, name: str, after_s: float) -> tuple[bool, str]:
        """Tell whether a user stays below the largest force after a time."""
        user = self._user(name)
        force = np.abs(user.f_applied[user.time_s > after_s]).max(initial=0.0)
        limit = float(self.scenario.users[0].safety.max_force)
        return force <= limit + 1e-9, f"{name} at most {force:.2f} N afterwards"

    def passive(self) -> tuple[bool, str]:
        """Tell whether every port that was judged is passive."""
        found = {user["name"]: user["passive"] for user in self.summary["users"]}
        bad = [name for name, value in found.items() if value is False]
        unknown = [name for name, value in found.items() if value is None]
        text = "passive" if not bad else f"not passive: {', '.join(bad)}"
        if unknown:
            text += f" (not evaluated: {', '.join(unknown)})"
        return not bad, text

    def _user(self, name: str) -> UserTraces:
        return next(user for user in self.traces.users if user.name == name)


def _behind_gaps(time_s: Array) -> list[float]:
    """Return the first time behind every pause of a loop [s]."""
    return time_s[1:][np.diff(time_s) > PAUSE_S].tolist()  # type: ignore[no-any-return]


def _first(user: UserTraces, after_s: float, state: int) -> float:
    rows = (user.block_time_s >= after_s) & (np.ravel(user.state) == state)
    times = user.block_time_s[rows]
    return float(times[0]) if len(times) else float("inf")


def killed_user() -> Outcome:
    """F01: a user is killed while both hold the cube."""
    live = Live("user_rejoin", "disturbances=6 kill user2", "duration_s=12")
    return joined(undisturbed(live.summary), live.stays("user1", live.times_s[0]), live.passive())


def rejoin() -> Outcome:
    """F02: the user comes back after 2 s."""
    live = Live("user_rejoin")
    return joined(
        undisturbed(live.summary),
        live.coupled("user2", live.times_s[1], 1.0),
        live.stays("user1", live.times_s[0]),
        live.passive(),
    )


def server() -> Outcome:
    """F03: the server is killed and started again."""
    live = Live("server_restart")
    return joined(
        undisturbed(live.summary),
        *(live.damped(name, live.times_s[0]) for name in ("user1", "user2")),
        *(live.coupled(name, live.times_s[1], 1.0) for name in ("user1", "user2")),
        live.passive(),
    )


def stopped(node: str, length_s: float) -> Outcome:
    """F04, F06: a node stands still for a while."""
    live = Live(
        "server_restart",
        f"disturbances=6 stop {node}; {6.0 + length_s} continue {node}",
        "duration_s=14",
    )
    parts = [undisturbed(live.summary), live.passive()]
    if node != "recorder" and length_s > 0.2:
        if node != "user1":
            parts.append(live.damped("user1", live.times_s[0]))
        parts.append(live.coupled("user1", live.times_s[1], 1.5))
    if node != "recorder":
        parts.append(live.together(live.times_s[1] + 1.5))
    return joined(*parts)


SLOW = """
import sys, time, rclpy
from pmwvc_core.runtime.topics import RECORDED_QOS
from pmwvc_msgs.msg import MasterTrace, ServerTrace, Wave
rclpy.init()
node, taken = rclpy.create_node("slow"), []
def take(message):
    time.sleep(1.0)
    taken.append(message)
for topic, kind in (("/user1/trace", MasterTrace), ("/server/trace", ServerTrace)):
    node.create_subscription(kind, topic, take, RECORDED_QOS)
node.create_subscription(Wave, "/user1/wave_up", take, 10)
end_s = time.monotonic() + 7.0
while time.monotonic() < end_s:
    rclpy.spin_once(node, timeout_sec=0.1)
print(len(taken))
"""


def slow_subscriber() -> Outcome:
    """F15: a subscriber of the traces and of a wave takes one message a second."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "session"
        words = ["run", "carry_16ms", "--duration", "9", "--out", str(folder)]
        command = [str(ROOT / "pmwvc"), *words]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as session:
            assert session.stdout is not None
            domain = ""
            for line in session.stdout:
                domain = domain or "".join(re.findall(r"ROS_DOMAIN_ID=(\d+)", line))
                if domain and " / 9 s" in line:
                    break
            surroundings = os.environ | {"ROS_DOMAIN_ID": domain}
            slow = subprocess.run(
                [sys.executable, "-c", SLOW],
                env=surroundings,
                capture_output=True,
                text=True,
                timeout=LIMIT_S,
                check=True,
            )
            session.stdout.read()
        traces = read_session(folder)
        found = json.loads((folder / "summary.json").read_text("utf-8"))
    taken = int(slow.stdout.split()[-1])
    lost = sum(found["recording"]["missing"].values())
    passive = all(user["passive"] for user in found["users"])
    server, users = traces.server, traces.users
    assert server is not None
    steps = np.diff(server.step)
    whole = bool((steps == 1).all()) and all((np.diff(u.block_number) == 1).all() for u in users)
    return joined(
        (taken > 1, f"took {taken} of some 2000 messages"),
        (lost == 0 and whole, f"{lost} missing in the recording"),
        (passive, "passive" if passive else "not passive"),
    )


def surroundings() -> Outcome:
    """F27: another language, time zone and year: the same bits."""
    found = {}
    for name, own in {
        "UTC": {"TZ": "UTC", "LC_ALL": "C"},
        "Turkish, Kiritimati": {"TZ": "Pacific/Kiritimati", "LC_ALL": "tr_TR.UTF-8"},
        "German, New York": {"TZ": "America/New_York", "LC_ALL": "de_DE.UTF-8"},
    }.items():
        with tempfile.TemporaryDirectory() as place:
            words = ["simulate", "carry_16ms", "--duration", "2", "--out", f"{place}/s", "--json"]
            ran = subprocess.run(
                [str(ROOT / "pmwvc"), *words],
                capture_output=True,
                text=True,
                env=os.environ | own,
                check=True,
            )
            document = json.loads(ran.stdout)
            found[name] = json.dumps([document["users"], document["links"]], sort_keys=True)
    same = len(set(found.values())) == 1
    return joined((same, f"{len(found)} environments, {len(set(found.values()))} result"))


WANTED = "no step, passive, the others continue"
WANTED_AFTER = "no step, passive, coupled and offset within the bound after 1.5 s"
PROCESSES = (
    Fault("F01", "a user is killed during the grip", WANTED, killed_user, live=True),
    Fault(
        "F02",
        "a user is killed and restarted after 2 s (`user_rejoin`)",
        f"{WANTED}; coupled within 1 s of its first tick",
        rejoin,
        live=True,
    ),
    Fault(
        "F03",
        "the server is killed and restarted after 1 s (`server_restart`)",
        "no step, damping within 0.2 s, coupled within 1 s of its first step",
        server,
        live=True,
    ),
    *(
        Fault(
            f"F04{letter}",
            f"{node} is stopped for {length:g} s (SIGSTOP)",
            wanted,
            partial(stopped, node, length),
            live=True,
        )
        for letter, node, length, wanted in (
            ("a", "user1", 0.3, WANTED_AFTER),
            ("b", "server", 1.0, "as F04a"),
            ("c", "recorder", 1.0, "as F04a"),
        )
    ),
    Fault(
        "F06",
        "the emulator is stopped for 0.5 s (SIGSTOP)",
        "as F04a",
        lambda: stopped("netem", 0.5),
        live=True,
    ),
    Fault(
        "F15",
        "a subscriber of traces takes one message a second",
        "every message reaches the recorder",
        slow_subscriber,
        live=True,
    ),
    Fault(
        "F27", "other languages and time zones", "the same numbers to the last bit", surroundings
    ),
)
