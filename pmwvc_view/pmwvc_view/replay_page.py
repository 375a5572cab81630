# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session as a file for the browser: the live page with the session in it, without a
server. Questions to the exact model are not answered there.
"""

import base64
import json
import posixpath
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces
from pmwvc_view import SNAPSHOT_S
from pmwvc_view.recorded import RecordedSession
from pmwvc_view.web.access import PAGE

ROWS, PACKETS = 4000, 40_000  # at most; of longer sessions fewer a second
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; "
    "style-src 'unsafe-inline'; img-src data:"
)


def replay_page(
    traces: SessionTraces, scenario: Scenario, summary: Mapping[str, Any]
) -> str | None:
    """Return the page of a session with its ``summary``; None if nothing of its users is known."""
    names = {user.name for user in scenario.users} & {user.name for user in traces.users}
    if not names:
        return None
    period_s = max(SNAPSHOT_S, traces.duration_s / ROWS)
    session = RecordedSession(traces, scenario, summary, snapshot_s=period_s)
    packets = session.packets
    arrived = np.isfinite(packets[:, 3])  # all that were lost are kept
    kept = ~arrived | (np.cumsum(arrived) % (len(packets) // PACKETS + 1) == 0)
    content = {
        "declared": session.declared(),
        "texts": session.texts(),
        "rows": _packed(session.rows),
        "packets": _packed(packets[kept]),
    }
    return _page(json.dumps(content, allow_nan=False).replace("<", "\\u003c"))


def _packed(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode("ascii")


def _page(content: str) -> str:
    """Return the page with style, scripts and session in it."""
    text = (PAGE / "index.html").read_text("utf-8")
    icon = _address((PAGE / "icon.svg").read_bytes(), "image/svg+xml")
    modules = {}
    for file in PAGE.rglob("*.js"):
        name = file.relative_to(PAGE.parent).as_posix()

        def named(found: re.Match[str], folder: str = posixpath.dirname(name)) -> str:
            return f'from "{posixpath.normpath(posixpath.join(folder, found[1]))}"'

        module = re.sub(r"""from ["'](\.[^"']+)["']""", named, file.read_text("utf-8"))
        modules[name] = _address(module.encode(), "text/javascript")
    style = (PAGE / "page.css").read_text("utf-8")
    text = re.sub(r'  <link rel="(modulepreload|stylesheet)".*\n', "", text)
    text = text.replace('href="icon.svg"', f'href="{icon}"')
    head = f"""  <meta http-equiv="Content-Security-Policy" content="{POLICY}">
  <style>{style}</style>
  <script type="importmap">{json.dumps({"imports": modules})}</script>
  <script type="application/json" id="recording">{content}</script>
  <script type="module">import "page/main.js";</script>
"""
    return text.replace('  <script type="module" src="main.js"></script>\n', head)


def _address(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
