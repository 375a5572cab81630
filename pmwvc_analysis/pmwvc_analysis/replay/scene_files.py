# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The files of a recorded scene, written out again."""

import base64
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from posixpath import normpath
from typing import Any


@contextmanager
def as_described(scenario: Any, server: Any) -> Iterator[Any]:
    """Yield a scenario with the scene of the server's traces, whatever became of its files; they
    are written into a folder that lasts as long as the block.
    """
    files = server.scene.get("files") if server is not None else None
    if not files:
        yield scenario
        return
    with tempfile.TemporaryDirectory(prefix="pmwvc-scene-") as root:
        # A path may lead out of the scene's folder, never out of this one.
        above = max((Path(normpath(path)).parts.count("..") for path in files), default=0)
        folder = Path(root, *["in"] * above)
        for path, content in files.items():
            target = folder / normpath(path).lstrip("/")
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(base64.b64decode(content))
        scene = str(folder / next(iter(files)))
        yield replace(scenario, server=replace(scenario.server, scene=scene))
