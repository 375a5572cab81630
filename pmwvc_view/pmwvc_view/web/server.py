# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server of the page: its files, and a socket per page. No ROS.

One event loop does everything: it polls the session once a snapshot, and hands requests to it as
they come. A page can do what a hand can do; whatever it sends is checked and counted here.
"""

import asyncio
import contextlib
import http
import socket
from collections.abc import Callable, Mapping
from threading import Event
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from pmwvc_core.runtime.interrupts import Interrupts
from pmwvc_view import SNAPSHOT_S, protocol
from pmwvc_view.protocol.snapshot import Snapshot
from pmwvc_view.session import Session
from pmwvc_view.web import access
from pmwvc_view.web.client import Client, Handling

MOST_PAGES = 32
CLOSE_S = 1.0  # for a page to answer that its socket is closed
UNSEEN_S = 0.128  # between two polls while there is no page: a node's traces wait as long
LISTEN_S = 0.004  # between two polls at least: what pages sent must not wait for a busy session
LISTENED_S = 0.05  # between two polls at most
NEWS_EVERY = 8  # polls
STARTED_LATE_S = 0.25  # a poll later than this does not catch up


class PageServer:
    """A session for any number of pages. Port 0 takes any that is free; ``port`` is then the one
    that is listened on.
    """

    def __init__(
        self, session: Session, *, host: str, port: int, token: str, poll_s: float = SNAPSHOT_S
    ) -> None:
        self._session, self._poll_s = session, poll_s
        self._host, self.port, self._token = host, port, token
        self._access = access.Access(host, token)
        self._clients: dict[ServerConnection, Client] = {}
        self._handling = Handling(session, self._tell_users)
        self._generation = session.generation
        self._news: dict[str, Mapping[str, Any]] = {}
        self._newest: Snapshot | None = None
        self._watched = asyncio.Event()

    @property
    def address(self) -> str:
        """Address of the page, with its token."""
        host = socket.gethostname() if self._host in ("0.0.0.0", "::") else self._host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/?token={self._token}"

    def run(self, stop: Event | Interrupts, ready: Callable[[], None]) -> None:
        """Serve until asked to stop or the session is over, ``ready`` called once that begins;
        OSError where the address cannot be listened on.
        """
        asyncio.run(self._serve(stop, ready))

    async def _serve(self, stop: Event | Interrupts, ready: Callable[[], None]) -> None:
        server = await serve(
            self._serve_page, self._host, self.port, process_request=self._answered,
            compression=None, max_size=protocol.MESSAGE_BYTES, server_header=None,
            close_timeout=CLOSE_S,
        )  # fmt: skip
        try:
            self.port = int(next(iter(server.sockets)).getsockname()[1])
            ready()
            await self._pace(stop)
        finally:
            text = self._session.ended or "the page's server was ended"
            ended = {"kind": "ended", "text": text}
            if access.is_loopback(self._host):
                ended["report"] = self._session.report
            self._tell(ended)
            self._session.close()
            await asyncio.gather(*(client.close() for client in self._clients.values()))
            server.close()
            await server.wait_closed()

    async def _pace(self, stop: Event | Interrupts) -> None:
        """Poll the session, once a snapshot."""
        loop, session = asyncio.get_running_loop(), self._session
        before_s = due_s = loop.time()
        polls = 0
        while not stop.is_set() and session.ended is None:
            now_s = loop.time()
            # While the server stood still, what pages sent waited.
            self._handling.listened(min(now_s - before_s, LISTENED_S))
            before_s = now_s
            snapshots = session.poll()
            if session.generation != self._generation:  # described anew to every page
                self._generation = session.generation
                self._news, self._newest = {}, None
                self._handling.begin()
                for client in self._clients.values():
                    client.begin(session.layout)
                    client.send(self._description(client))
            if snapshots:
                self._newest = snapshots[-1]
                for client in self._clients.values():
                    client.show(snapshots)
            if polls % NEWS_EVERY == 0 or not self._clients:
                for kind, content in session.news().items():
                    if self._news.get(kind) != content:
                        self._news[kind] = dict(content)
                        self._tell({"kind": kind, **content})
            polls += 1
            due_s = max(due_s + self._poll_s, now_s - STARTED_LATE_S)
            if self._clients:
                await asyncio.sleep(max(due_s - loop.time(), LISTEN_S))
            else:
                self._watched.clear()
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._watched.wait(), UNSEEN_S)
                due_s = loop.time()

    def _tell(self, message: Mapping[str, Any]) -> None:
        for client in self._clients.values():
            client.send(message)

    def _tell_users(self) -> None:
        for client in self._clients.values():
            holders = self._handling.holders(client).items()
            users = [{"name": user, "holder": holder} for user, holder in holders]
            client.send({"kind": "users", "users": users})

    def _description(self, client: Client) -> dict[str, Any]:
        """Return the session message for a page."""
        return self._session.message(self._handling.holders(client))

    def _answered(self, _: ServerConnection, request: Request) -> Response | None:
        """Return the answer to a request; None for a socket that may connect."""
        hosts = request.headers.get_all("Host")
        if why := self._access.host_refused(hosts, self.port):
            return _answer(http.HTTPStatus.FORBIDDEN, why)
        path = urlsplit(request.path).path
        if path != access.SOCKET:
            if (file := access.page_file(path)) is None:
                return _answer(http.HTTPStatus.NOT_FOUND, "there is no such file")
            return _answer(http.HTTPStatus.OK, *file)
        origins = request.headers.get_all("Origin")
        if why := self._access.socket_refused(request.path, origins, hosts[0]):
            return _answer(http.HTTPStatus.FORBIDDEN, why)
        if len(self._clients) >= MOST_PAGES:
            text = f"{MOST_PAGES} pages are connected already"
            return _answer(http.HTTPStatus.SERVICE_UNAVAILABLE, text)
        return None

    async def _serve_page(self, socket: ServerConnection) -> None:
        """Serve one page until it is gone; then its handles are free."""
        client = Client(socket, self._session.layout)
        client.send(self._description(client))
        for kind, content in self._news.items():
            client.send({"kind": kind, **content})
        if self._newest is not None:
            client.show([self._newest])
        self._clients[socket] = client
        self._watched.set()
        why = ""
        try:
            why = await client.run(lambda request: self._handling.handle(client, request))
        finally:
            del self._clients[socket]
            self._handling.gone(client)
        if why:
            await client.refuse(why)


def _answer(
    status: http.HTTPStatus, content: bytes | str, kind: str = "text/plain; charset=utf-8"
) -> Response:
    body = content if isinstance(content, bytes) else f"{content}\n".encode()
    headers = Headers({**access.HEADERS, "Content-Type": kind})
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)
