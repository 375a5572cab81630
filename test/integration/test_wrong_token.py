# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A master and a server whose tokens are not of one session."""

import pytest
from support.processes import NodeProcess

from pmwvc_core.params import OperatorParams
from pmwvc_core.runtime.token_files import write_session

pytestmark = pytest.mark.integration


@pytest.mark.parametrize("wrong", ["another session's", "none"])
def test_a_wrong_token_is_said_at_both_terminals(tmp_path, wrong):
    for name in ("ours", "theirs"):
        write_session(tmp_path / name, ["user1"])
    given = {"session.token_file": str(tmp_path / "theirs" / "user1")} if wrong != "none" else {}
    ways = [f"{way}:=/server/user1/{way}" for way in ("wave_up", "wave_down")]
    server = NodeProcess(
        "pmwvc_server.node",
        {"users": ["user1"], "session.token_file": str(tmp_path / "ours" / "server")},
    )
    master = NodeProcess(
        "pmwvc_master.node",
        {**given, "operator": OperatorParams(kind="none")},
        arguments=("-r", "__ns:=/user1", *(word for way in ways for word in ("-r", way))),
    )
    with server, master:
        for node, way in ((server, "up"), (master, "down")):
            node.await_output(f"/server/user1/wave_{way}: ")
            node.await_output("of another session refused: session.token_file")
        assert (master.stop(), server.stop()) == (0, 0)
