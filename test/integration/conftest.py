# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Live sessions that several files read; none of them changes anything in the folder."""

import signal
from contextlib import ExitStack

import pytest
from support.excuses import pytest_runtest_makereport, pytest_runtest_protocol  # noqa: F401
from support.peers import ros
from support.sessions import Running, shared_memory_of

CHANGES = [
    ("/user1/master", {"master.rate_drop": 20}),
    ("/server", {"server.period_s": 0.005}),
    ("/user2/master", {"master.rate_drop": 5}),
]
BOTH_S = 3.5  # of two sessions, at once or side by side


@pytest.fixture(scope="session")
def impaired(tmp_path_factory):
    """A session on the strict channel, over a network that delays, loses, copies and reorders
    packets; the rates change while it runs.
    """
    folder = tmp_path_factory.mktemp("impaired") / "session"
    link = {"delay_s": 0.012, "jitter": "uniform", "jitter_s": 0.006, "loss": 0.1}
    link |= {"duplicate": 0.05, "keep_order": "false"}
    words = [word for name, value in link.items() for word in ("--set", f"link.{name}={value}")]
    with Running(folder, "carry_16ms", "--duration", 600, *words) as session:
        with ros(domain=session.domain()) as peer:
            for _ in range(2):  # 3 s: a recorder that a busy machine starts late listens by then
                session.await_ticks()
            for node, values in CHANGES:
                assert peer.set_parameters(node, values) == [""]
            session.await_ticks()  # 5 s, or later: the hands have closed and hold
            session.process.send_signal(signal.SIGINT)
        session.code = session.end()
        yield session


@pytest.fixture(scope="session")
def carried(tmp_path_factory):
    """One undisturbed session of 4 s, with figures: the hands have closed and hold."""
    folder = tmp_path_factory.mktemp("carried") / "session"
    with Running(folder, "carry_16ms", "--duration", 4, figures=True) as session:
        session.await_ticks()
        session.seen = session.nodes()
        session.shared_memory = {name: shared_memory_of(pid) for name, pid in session.seen.items()}
        session.code = session.end()
        session.left = session.nodes()
        yield session


@pytest.fixture(scope="session")
def pair(tmp_path_factory):
    """Two sessions at once, of two controllers without waves."""
    found = {}
    with ExitStack() as stack:
        for controller in ("virtual_coupling", "pspm"):
            folder = tmp_path_factory.mktemp(controller) / "session"
            words = ("wall", "--duration", BOTH_S, "--json", "--set", f"controller={controller}")
            found[controller] = stack.enter_context(Running(folder, *words))
        for session in found.values():
            session.code = session.end()
        for session in found.values():
            session.left = session.nodes()
        yield found


@pytest.fixture(scope="session")
def given_damping(tmp_path_factory):
    """A session of a controller without waves whose parameter is given, over links of 4 ms."""
    folder = tmp_path_factory.mktemp("tdpa") / "session"
    settings = ("controller=tdpa", "baseline.tdpa.damping=9", "link.delay_s=0.004")
    words = [word for setting in settings for word in ("--set", setting)]
    with Running(folder, "wall", "--duration", BOTH_S, "--json", *words) as session:
        session.code, session.left = session.end(), session.nodes()
        yield session
