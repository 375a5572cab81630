# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Live sessions that several files read; none of them changes anything in the folder."""

import pytest
from support.sessions import Running, shared_memory_of


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
