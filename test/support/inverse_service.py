# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A fake Inverse Service: one state per message, in the forms of versions 3.5 and 3.1.

It can hold its answers back, repeat them, send millimetres, drop connections, go and come again.
"""

import contextlib
import json
import queue
import threading

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

PATIENCE_S = 60.0
SETTINGS = {"gravity_compensation": {"enabled": True}}
OF_3_5 = {"filters": {"force_gate": {"gain": 0.3}}, "basis": {"permutation": "XYZ"}, "mount": {}}


def vector(values):
    return dict(zip("xyz", values, strict=True))


class InverseService:
    """The state is what the test says; ``forces`` are those of the messages that came."""

    def __init__(self, *, version="3.5", ids=("049D",), kind="inverse3"):
        self.version, self.ids, self.kind, self.port = version, ids, kind, 0
        self.position, self.velocity = [0.0, -0.12, 0.15], [0.0, 0.0, 0.0]
        self.status = {"calibrated": True}
        self.copies = 1  # of each answer
        self.grips = []  # wireless VerseGrips
        self.held = None  # answers that wait
        self._holding = threading.Lock()
        self.forces: queue.Queue = queue.Queue()
        self.connections = []
        self.start()

    @property
    def url(self):
        return f"ws://127.0.0.1:{self.port}"

    def start(self):
        self._server = serve(self._serve, "127.0.0.1", self.port)
        self.port = self._server.socket.getsockname()[1]
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def stop(self):
        self.drop()
        self._server.shutdown()
        self._thread.join(PATIENCE_S)

    def drop(self):
        while self.connections:
            self.connections.pop().close_socket()

    def hold(self):
        self.held = []

    def release(self, count=None):
        """Send answers that were held back, the first ones or all."""
        with self._holding:
            for connection, answer in self.held[:count]:
                with contextlib.suppress(ConnectionClosed):  # the device may have gone
                    connection.send(answer)
            self.held = self.held[count:] if count else None

    def force(self):
        """Return the next force that came [N], by id; it is waited for."""
        return self.forces.get(timeout=PATIENCE_S)

    def answer(self, *, config=False):
        new = self.version == "3.5"
        state = {
            "cursor_position": vector(self.position),
            "cursor_velocity": vector(self.velocity),
        }
        devices = [{"device_id": each, "state": state, "status": self.status} for each in self.ids]
        for device in devices if config else ():
            settings = SETTINGS | (OF_3_5 | {"type": self.kind} if new else {})
            device["config"] = {"handedness": "right"} | settings
        there = {"inverse3": devices} | ({"wireless_verse_grip": self.grips} if self.grips else {})
        return json.dumps(({"session_id": 7} if new else {}) | there)

    def _serve(self, connection):
        self.connections.append(connection)
        connection.send(self.answer(config=True))
        try:
            for message in connection:
                for device in json.loads(message)["inverse3"]:
                    form = "vector" if self.version == "3.5" else "values"
                    force = device["commands"]["set_cursor_force"].get(form)
                    answers = [(connection, self.answer())] * self.copies
                    with self._holding:
                        if self.held is not None:
                            self.held += answers
                        else:
                            for _, answer in answers:
                                connection.send(answer)
                    # Last: who has seen the force knows that it is answered, or held.
                    self.forces.put((device["device_id"], force))
        except ConnectionClosed:
            pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
