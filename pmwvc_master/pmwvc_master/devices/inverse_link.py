# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A WebSocket to a service on this machine, in the thread of a loop, which it never blocks.

Of ``websockets`` the protocol is used, which is apart from sockets: its ready clients read in a
thread of their own, with which a loop would share the interpreter, and wait for a handshake.
"""

import contextlib
import select
import socket

from websockets.client import ClientProtocol
from websockets.exceptions import WebSocketException
from websockets.frames import Frame, Opcode
from websockets.uri import WebSocketURI

READ, MOST = 1 << 16, 1000  # bytes at once; messages, of a second


class LinkLost(Exception):
    """The service is gone, or what answers is none."""


class InverseLink:
    """One connection, which may still be under way; every call raises LinkLost once it is lost."""

    def __init__(self, uri: WebSocketURI, host: str) -> None:
        self._protocol = ClientProtocol(uri)
        self._socket = socket.socket()
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.connect_ex((host, uri.port))  # refused later, by a call
        self.close = self._socket.close
        self._waiting, self._part = b"", b""  # to be sent; of a message
        self._protocol.send_request(self._protocol.connect())

    def send(self, text: str) -> None:
        """Send a message, without waiting."""
        try:
            self._protocol.send_text(text.encode())
        except WebSocketException as error:
            raise LinkLost(str(error)) from error
        self._flush()

    def take(self, wait_s: float = 0.0) -> list[bytes]:
        """Return all messages that wait, a second's at most; for the first one wait ``wait_s``."""
        messages: list[bytes] = []
        with contextlib.suppress(BlockingIOError):
            self._flush()
            select.select([self._socket], [], [], wait_s)
            while len(messages) < MOST:
                messages += self._received()
        return messages

    def _received(self) -> list[bytes]:
        """Return the messages of a piece of the stream; BlockingIOError where there is none."""
        try:
            data = self._socket.recv(READ)
        except BlockingIOError:
            raise
        except OSError as error:
            raise LinkLost(error.strerror or str(error)) from error
        if not data:
            raise LinkLost("connection closed")
        self._protocol.receive_data(data)
        messages = []
        if self._protocol.handshake_exc is not None:
            raise LinkLost(f"no WebSocket: {self._protocol.handshake_exc}")
        for event in self._protocol.events_received():
            if isinstance(event, Frame) and event.opcode in (Opcode.TEXT, Opcode.CONT):
                self._part += event.data
                if event.fin:
                    messages.append(self._part)
                    self._part = b""
        return messages

    def _flush(self) -> None:
        self._waiting += b"".join(self._protocol.data_to_send())
        try:
            while self._waiting:
                self._waiting = self._waiting[self._socket.send(self._waiting) :]
        except BlockingIOError:
            pass  # the service reads no more, and will be silent
        except OSError as error:
            raise LinkLost(error.strerror or str(error)) from error
