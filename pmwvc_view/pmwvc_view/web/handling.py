# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of pages, carried out in the session and answered; who owns which handle."""

import asyncio
from collections.abc import Callable
from typing import Any

from pmwvc_view.protocol import requests
from pmwvc_view.session import Answer, Session
from pmwvc_view.web.client import Client
from pmwvc_view.web.handles import Handles

SETTLED = 64  # acknowledgements: what can wait begins, the page is there


class Handling:
    """What pages ask for; ``tell_users`` tells every page who owns which handle."""

    def __init__(self, session: Session, tell_users: Callable[[], None]) -> None:
        self._session, self._tell_users = session, tell_users
        self._handles = Handles(_remote(session))
        self._shown = 0
        self._tasks: set[asyncio.Task[None]] = set()

    def begin(self) -> None:
        """Begin anew with the session; handles stay whose they are."""
        before, self._handles = self._handles, Handles(_remote(self._session))
        for user, owner in before.owners().items():
            self._handles.take(user, owner)

    def holders(self, client: Client) -> list[dict[str, Any]]:
        """Return who holds which handle, as a page is told."""
        found = []
        for user in self._session.description()["users"]:
            owner = self._handles.owner(user["name"])
            holder = None if owner is None else "you" if owner is client else "other"
            found.append({"name": user["name"], "holder": holder})
        return found

    def open_silent(self, now_s: float) -> None:
        """Open the hands that got no target for too long [s]."""
        for user in self._handles.silent(now_s):
            self._session.target(user, None)

    def gone(self, client: Client) -> None:
        """Free the handles of a page that is gone."""
        for user in self._handles.owned(client):
            self._free(user)

    def _free(self, user: str) -> None:
        self._open(user)
        self._handles.free(user)
        self._tell_users()

    def _open(self, user: str) -> None:
        self._handles.opened(user)
        self._session.target(user, None)

    def handle(self, client: Client, request: requests.Request) -> None:
        """Do what a page asks for; answers that take their time come later."""
        session = self._session
        if isinstance(request, requests.Seen):
            client.seen(request.seq)
            self._shown += 1
            if self._shown == SETTLED:
                session.expect_questions()
        elif isinstance(request, requests.Target):
            self._target(client, request)
        elif request.kind not in session.can:
            self._answer(client, request, Answer(False, f"{request.kind}: not in this session"))
        elif isinstance(request, requests.Take):
            why = self._handles.take(request.user, client)
            self._answer(client, request, Answer(why is None, why or ""))
            self._tell_users()
        elif isinstance(request, requests.LetGo):
            mine = self._handles.owner(request.user) is client
            if mine:
                self._free(request.user)
            self._answer(client, request, Answer(mine, "" if mine else "it is not yours"))
        elif isinstance(request, requests.Set | requests.Ask | requests.Pause):
            task = asyncio.create_task(self._later(client, request))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
        else:
            self._answer(client, request, self._at_once(request))

    def _target(self, client: Client, request: requests.Target) -> None:
        if self._handles.owner(request.user) is not client:
            return
        if request.position is None:
            self._open(request.user)
        else:
            self._handles.held(request.user, asyncio.get_running_loop().time())
            self._session.target(request.user, request.position)

    def _at_once(self, request: requests.Request) -> Answer:
        session = self._session
        if isinstance(request, requests.Restart):
            return session.restart(request.values)
        if isinstance(request, requests.Seek):
            return session.seek(request.time_s)
        if isinstance(request, requests.Speed):
            return session.speed(request.ratio)
        raise TypeError(request.kind)

    async def _later(
        self, client: Client, request: requests.Set | requests.Ask | requests.Pause
    ) -> None:
        if isinstance(request, requests.Pause):
            self._answer(client, request, await self._session.pause(request.paused))
        elif isinstance(request, requests.Set):
            self._answer(client, request, await self._session.set(request.path, request.value))
        else:
            found = await self._session.ask(request.values)
            if found is not None:
                client.send({"kind": "prediction", "id": request.id, **found})

    def _answer(self, client: Client, request: Any, answer: Answer) -> None:
        if request.id is not None:
            client.send({"kind": "answer", "id": request.id, **answer._asdict()})


def _remote(session: Session) -> list[str]:
    return [user["name"] for user in session.description()["users"] if user["remote"]]
