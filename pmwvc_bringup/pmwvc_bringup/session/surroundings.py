# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The surroundings of a live session: its folder, ROS domain and environment variables."""

import contextlib
import os
import re
import socket
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from pmwvc_bringup.scenarios import folders
from pmwvc_core.errors import PmwvcError

SESSIONS = "sessions"
RANGE, LOCALHOST = "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
DOMAINS = range(1, 102)  # above, the ports of a domain overlap those the kernel hands out
RESERVING_PORT = 21_000  # + domain, TCP: also bound by tests that use a domain


def new_folder(scenario: str, out: str | None) -> Path:
    """Make and return a new session's folder; PmwvcError where it is not empty or cannot be."""
    if out is None:
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
        plain = re.sub(r"[^A-Za-z0-9_.-]+", "_", scenario)
        base = folder = Path(SESSIONS, f"{stamp}-{plain}")
        number = 1
        while folder.exists():  # two sessions that start within one second
            number += 1
            folder = base.with_name(f"{base.name}-{number}")
    else:
        folder = Path(out).expanduser()
        if folder.is_dir() and any(folder.iterdir()):
            raise PmwvcError(f"{folder} is not empty: a session needs a folder of its own")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror or error
        raise PmwvcError(f"{folder} cannot be made: {reason}; choose another with --out") from None
    return folder


@contextlib.contextmanager
def own_domain(environment: Mapping[str, str]) -> Iterator[int]:
    """Yield the ROS domain of a session: the user's, or one that is free on this machine.

    Sockets reserve it against other sessions; they go away with this process, however it ends.
    PmwvcError where the user's choice is no domain or holds another session, or all are taken.
    """
    given = environment.get("ROS_DOMAIN_ID", "")
    if given and not (given.isdigit() and int(given) <= 232):
        raise PmwvcError(f"ROS_DOMAIN_ID={given}: must be a number, 0..101; or unset it")
    first = os.getpid() % len(DOMAINS)
    for domain in [int(given)] if given else [*DOMAINS[first:], *DOMAINS[:first]]:
        with contextlib.ExitStack() as reservations:
            if not _held(f"\0pmwvc-domain-{domain}", reservations):
                continue
            port = ("127.0.0.1", RESERVING_PORT + domain)
            if given or (_held(port, reservations) and _silent(domain)):
                yield domain
                return
    if given:
        raise PmwvcError(f"ROS_DOMAIN_ID={given}: another session runs there; unset it, or wait")
    raise PmwvcError("every ROS domain from 1 to 101 is in use on this machine")


def running_domains() -> list[int]:
    """Return the ROS domains of the sessions that run on this machine."""
    with contextlib.ExitStack() as probes:
        return [n for n in range(102) if not _held(f"\0pmwvc-domain-{n}", probes)]


def _held(address: str | tuple[str, int], until: contextlib.ExitStack) -> bool:
    """Tell whether an address was free; it stays bound to a socket until the stack closes."""
    family = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
    reservation = until.enter_context(socket.socket(family, socket.SOCK_STREAM))
    try:
        reservation.bind(address)
    except OSError:
        return False
    return True


def _silent(domain: int) -> bool:
    """Tell whether no ROS program of this machine uses a domain, from its discovery ports."""
    base = 7400 + 250 * domain
    for port in (base, base + 10):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("0.0.0.0", port))
            except OSError:
                return False
    return True


def node_environment(
    environment: Mapping[str, str], *, domain: int, log_folder: Path
) -> dict[str, str]:
    """Return the environment of the session's nodes.

    They connect on this machine only, over the loopback interface, unless the user sets another
    range; never over shared memory, of which a killed node leaves files behind.
    """
    given = {RANGE: LOCALHOST} | {name: value for name, value in environment.items() if value}
    chosen = own_environment(given)
    fixed = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_LOG_DIR": str(log_folder.resolve()),
        "RCUTILS_COLORIZED_OUTPUT": "0",
        "PYTHONUNBUFFERED": "1",
        "PYTHONSAFEPATH": "1",  # a file in the user's folder never stands in for a module
    }
    return {**chosen, **fixed}


def own_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without shared memory, also for a node that is started by hand; its
    publishers ask often what is missing.

    Given values stay, except a range of discovery that brings shared memory with it.
    """
    given = {name: value for name, value in environment.items() if value}
    profiles = "any_machine.xml"
    if given.get(RANGE, "").upper() == LOCALHOST:
        given[RANGE], profiles = "SYSTEM_DEFAULT", "this_machine.xml"
    chosen = {
        "AMENT_PREFIX_PATH": sys.prefix,
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(folders()[0] / profiles),
    }
    return {**chosen, **given}
