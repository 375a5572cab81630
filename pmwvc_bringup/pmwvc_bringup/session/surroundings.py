# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Before a session: its folder, ROS domain and environment variables; and the check of its
scenario: recordings, delay traces and plug-ins it names, filters without a design. Needs no ROS.
"""

import contextlib
import importlib.util
import os
import re
import socket
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import chain, count
from pathlib import Path

from pmwvc_bringup.scenarios import folders
from pmwvc_core.errors import PmwvcError, ScenarioError
from pmwvc_core.network import effects
from pmwvc_core.scenario.conflicts import disturbances_of
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server import environments

SESSIONS = "sessions"
RANGE, LOCALHOST = "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
DOMAINS = range(1, 102)  # above, the ports of a domain overlap those the kernel hands out
RESERVING_PORT = 21_000  # + domain, TCP: also bound by tests that use a domain


def new_folder(scenario: str, out: Path | str | None) -> Path:
    """Make and return a new session's folder; PmwvcError where it is not empty or cannot be."""
    if out is None:
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
        base = f"{stamp}-{re.sub(r'[^A-Za-z0-9_.-]+', '_', scenario)}"
        names = chain([base], (f"{base}-{number}" for number in count(2)))
        # two sessions may start within one second
        folder = next(path for name in names if not (path := Path(SESSIONS, name)).exists())
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


def _held(
    address: str | tuple[str, int], until: contextlib.ExitStack, kind: int = socket.SOCK_STREAM
) -> bool:
    """Tell whether an address was free; it stays bound to a socket until the stack closes."""
    family = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
    reservation = until.enter_context(socket.socket(family, kind))
    try:
        reservation.bind(address)
    except OSError:
        return False
    return True


def _silent(domain: int) -> bool:
    """Tell whether no ROS program of this machine uses a domain, from its discovery ports."""
    ports = (7400 + 250 * domain, 7410 + 250 * domain)
    with contextlib.ExitStack() as probes:
        return all(_held(("0.0.0.0", port), probes, socket.SOCK_DGRAM) for port in ports)


def node_environment(
    environment: Mapping[str, str], *, domain: int, log_folder: Path
) -> dict[str, str]:
    """Return the environment of the session's nodes.

    They connect on this machine only, over the loopback interface, unless the user sets another
    range; never over shared memory, of which a killed node leaves files behind.
    """
    given = {RANGE: LOCALHOST} | {name: value for name, value in environment.items() if value}
    chosen = own_environment(given)
    return chosen | {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_LOG_DIR": str(log_folder.resolve()),
        "RCUTILS_COLORIZED_OUTPUT": "0",
        "PYTHONUNBUFFERED": "1",
        "PYTHONSAFEPATH": "1",  # a file in the user's folder never stands in for a module
    }


def own_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without shared memory, also for a node that is started by hand; its
    publishers ask often what is missing.

    Given values stay, except a range of discovery that brings shared memory with it.
    """
    given = {name: value for name, value in environment.items() if value}
    profiles = "any_machine.xml"
    if given.get(RANGE, "").upper() == LOCALHOST:
        given[RANGE], profiles = "SYSTEM_DEFAULT", "this_machine.xml"
    return {
        "AMENT_PREFIX_PATH": sys.prefix,
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(folders()[0] / profiles),
        **given,
    }


def check(scenario: Scenario) -> None:
    """Refuse a scenario that could not run: ScenarioError with every file and plug-in that cannot
    be used, each once, with its first user.
    """
    found: dict[str, str] = {}
    for who, needed in _needs(scenario):
        try:
            needed()
        except PmwvcError as error:
            found.setdefault(str(error), f"{who}{error}")
    if found:
        raise ScenarioError(scenario.name, [*found.values()])


def _needs(scenario: Scenario) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield calls, each with the user whose it is, that fail where something cannot be had."""
    from pmwvc_core.made.server import made_outside, server_params  # no help waits for the laws
    from pmwvc_core.simulation.bulk.run import made_end

    for user in scenario.users:
        who = f"{user.name}: "
        # Nodes and devices need ROS; the simulated one is there, installed or run from source.
        if not user.device.is_simulated and importlib.util.find_spec("pmwvc_master") is not None:
            from pmwvc_master.devices import PLUGINS

            yield who, partial(PLUGINS.required, user.device.plugin)
        yield who, partial(made_end, scenario, user)
        for link in (user.link_up, user.link_down):
            yield who, partial(effects.check, link)
    yield "", partial(server_params, scenario.users, scenario, scenario.server)
    if (name := scenario.server.environment) not in environments.LIBRARY:
        yield "", partial(environments.PLUGINS.required, name)  # none is imported
    elif scenario.environment.outside:
        yield "", partial(made_outside, scenario.users, scenario)


def require_ros() -> None:
    """Refuse (PmwvcError) what needs ROS where there is none."""
    if importlib.util.find_spec("rclpy") is None:
        raise PmwvcError(
            "ROS 2 is not in this Python environment (no rclpy): run 'make setup' in the source "
            "tree, or source an installed ROS 2; only run and node need it, 'pmwvc simulate' and "
            "all other commands do not"
        )


def notes(scenario: Scenario) -> list[str]:
    """Return what a simulation leaves out of the scenario, in sentences."""
    disturbed = [f"Not simulated: {one}." for one in disturbances_of(scenario.disturbances)]
    return disturbed + [
        f"{user.name}: a simulated device replaces device.plugin = {user.device.plugin!r}."
        for user in scenario.users
        if not user.device.is_simulated
    ]
