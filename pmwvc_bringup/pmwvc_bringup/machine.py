# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The checks of this machine for live sessions: one finding each, with its remedy.

They change nothing. What only live sessions need is checked where there is Linux and ROS, and
loaded there: other systems lack its modules. Checks of a recorded session:
:mod:`pmwvc_analysis.doctor`.
"""

import importlib
import importlib.metadata
import importlib.util
import math
import os
import platform
import shutil
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeAlias, TypeVar

import numpy as np

from pmwvc_analysis.doctor import OK, PROBLEM, WARNING, Checked

MIB = 2**20
MIB_A_MINUTE, MIB_A_MINUTE_OF_USER = 2.1, 5.8  # of a live recording at 1 kHz, measured
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
TICK_NS = 1_000_000  # the force loop of every scenario
LINUX = "Linux"
LIVE_ONLY = "run make setup for live sessions; all commands but run and node work without"
Answer = TypeVar("Answer")
Outcome: TypeAlias = tuple[str, ...]  # status, text and, but where all is well, the remedy
Rule: TypeAlias = tuple[bool, str, str]  # whether it is broken, the status then, the remedy


def examine() -> list[Checked]:
    """Run every check of this system; one that fails itself is a problem of its own."""
    live = platform.system() == LINUX and importlib.util.find_spec("rclpy") is not None
    findings = []
    for name, check in (CHECKS if live else NOT_LIVE).items():
        try:
            findings.append(Checked(name, *check()))
        except Exception as error:  # a broken machine must not end the doctor
            text = f"the check failed: {type(error).__name__}: {error}"
            findings.append(Checked(name, PROBLEM, text, "report this as a bug"))
    return findings


def _judged(text: str, *rules: Rule) -> Outcome:
    """Return status and remedy of the first rule that is broken, else that all is well."""
    return next(((status, text, remedy) for broken, status, remedy in rules if broken), (OK, text))


def _python() -> Outcome:
    text = f"{platform.python_version()} in {sys.prefix}"
    wrong = not (3, 11) <= sys.version_info[:2] <= (3, 13)
    return _judged(text, (wrong, PROBLEM, "use Python 3.11 to 3.13: make setup"))


def _ros() -> Outcome:
    names = ("Wave", "MasterTrace", "ServerTrace", "PacketFate", "Reception")
    try:
        messages = importlib.import_module("pmwvc_msgs.msg")
        support = importlib.import_module("rclpy.type_support")
        for name in names:
            support.check_for_type_support(getattr(messages, name))
        version = f"rclpy {importlib.metadata.version('ros-rclpy')} from wheels"
    except importlib.metadata.PackageNotFoundError:
        version = "rclpy of a ROS installation"
    except Exception as error:
        return PROBLEM, f"{type(error).__name__}: {error}", LIVE_ONLY
    return OK, f"{version}; {len(names)} types of messages with their support libraries"


def _system() -> Outcome:
    """Return what a system without ROS is good for, which is no fault of it."""
    need = "ROS 2 (make setup)" if platform.system() == LINUX else "Linux"
    text = f"{platform.system()} {platform.machine()}: all commands but run and node"
    return OK, f"{text}; live sessions need {need}"


def _cores() -> Outcome:
    count, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    return _judged(
        f"{count} cores, load {load:.1f}",
        (count < 2, WARNING, "use two cores or more: on one, loops wait for each other"),
        (load > count, WARNING, "close other programs: loops will be late"),
    )


def _clock() -> Outcome:
    from pmwvc_core.runtime.pacing import Pacer

    resolution_ns = time.get_clock_info("monotonic").resolution * 1e9
    pacer = Pacer(TICK_NS)
    late_ns = _in_thread(lambda: [pacer.wait().lateness_ns for _ in range(300)])
    half, most = np.percentile(late_ns, (50, 99)) / 1e3
    text = f"resolution {resolution_ns:.0f} ns; 1 kHz wake-ups: median lateness {half:.0f} µs"
    return _judged(
        f"{text}, 99th percentile {most:.0f} µs",
        (resolution_ns > 1000, PROBLEM, "use a kernel with high-resolution timers"),
        (most > 1000, WARNING, "ticks will be late: the machine is busy or virtual"),
    )


def _real_time() -> Outcome:
    from pmwvc_core.runtime.pacing import granted_words, hold_memory, request_real_time

    report = _in_thread(lambda: hold_memory() | request_real_time(20))
    remedy = "set rtprio 20 and memlock unlimited in /etc/security/limits.conf; log in again"
    return _judged(granted_words(report), (any(report.values()), WARNING, remedy))


def _disk() -> Outcome:
    if not os.access(Path.cwd(), os.W_OK):
        return PROBLEM, "this folder is not writable", "use --out, or start in a writable folder"
    free = shutil.disk_usage(Path.cwd()).free / MIB
    sizes = {users: MIB_A_MINUTE + users * MIB_A_MINUTE_OF_USER for users in (2, 8)}
    texts = (f"{size:.0f} MiB a minute with {users} users" for users, size in sizes.items())
    return _judged(
        f"{free / 1024:.1f} GiB free here; a live session takes about {', '.join(texts)}",
        (free < 200, PROBLEM, "free disk space, or use --out"),
        (free < 2048, WARNING, "free disk space for long sessions, or use --out"),
    )


def _environment() -> Outcome:
    names = ("ROS_", "RMW_", "FASTDDS_", "FASTRTPS_", "CYCLONEDDS_")
    found = {k: v for k, v in sorted(os.environ.items()) if k.startswith(names)}
    domain = found.get("ROS_DOMAIN_ID") or "0"
    number = int(domain) if domain.isdigit() else math.inf
    distribution = found.get("ROS_DISTRO", "jazzy")
    middleware = found.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    alone = f"{RANGE}=OFF: nodes do not discover each other; unset it"
    return _judged(
        " ".join(f"{name}={value}" for name, value in found.items()) or "nothing set",
        (number > 232, PROBLEM, "ROS_DOMAIN_ID must be 0 to 101: change or unset it"),
        (number > 101, WARNING, "ROS_DOMAIN_ID above 101: ports may be taken"),
        (distribution != "jazzy", PROBLEM, "another ROS is sourced: use a fresh shell"),
        (middleware != "rmw_fastrtps_cpp", WARNING, "only rmw_fastrtps_cpp is tested; unset it"),
        (found.get(RANGE, "").upper() == "OFF", PROBLEM, alone),
    )


def _in_thread(work: Callable[[], Answer]) -> Answer:
    """Return what work in a thread of its own gives: its scheduling parameters end with it."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()


CHECKS: dict[str, Callable[[], Outcome]] = {
    "python": _python, "ros": _ros, "cores": _cores, "clock": _clock, "real time": _real_time,
    "disk": _disk, "environment": _environment,
}  # fmt: skip
NOT_LIVE: dict[str, Callable[[], Outcome]] = {"python": _python, "system": _system, "disk": _disk}
