# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Live sessions that several files read; none of them changes anything in the folder."""

import pytest
from support.sessions import Running, shared_memory_of


@pytest.fixture(scope="session")
def impaired(tmp_path_factory):
    """A session of 4 s on the strict channel, over a network with jitter, loss and duplicates."""
    folder = tmp_path_factory.mktemp("impaired") / "session"
    link = {"jitter": "uniform", "jitter_s": 0.006, "loss": 0.1, "duplicate": 0.05}
    words = [word for name, value in link.items() for word in ("--set", f"link.{name}={value}")]
    with Running(folder, "carry_16ms", "--duration", 4, *words) as session:
        session.code = session.end()
        yield session


@pytest.fixture(scope="session")
def carried(tmp_path_factory):
    """One undisturbed session of 4 s: the hands have closed and hold."""
    folder = tmp_path_factory.mktemp("carried") / "session"
    with Running(folder, "carry_16ms", "--duration", 4) as session:
        session.await_ticks()
        session.seen = session.nodes()
        session.shared_memory = {name: shared_memory_of(pid) for name, pid in session.seen.items()}
        session.code = session.end()
        session.left = session.nodes()
        yield session
