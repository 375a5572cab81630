# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of pages, carried out in the session and answered; who owns which handle."""

import asyncio
from collections.abc import Callable
from typing import Any

from pmwvc_view.protocol import SILENCE_S
from pmwvc_view.protocol.requests import Request
from pmwvc_view.session import Answer, Session
from pmwvc_view.web.client import Client

SETTLED = 64  # acknowledgements: what can wait begins, the page is there
MOST_AT_ONCE = 8  # changes of one page that are under way
AGAIN_S = 1.0  # between two beginnings


class Handling:
    """The requests of pages, answered; ``tell_users`` tells every page who owns which handle."""

    def __init__(self, session: Session, tell_users: Callable[[], None]) -> None:
        self._session, self._tell_users = session, tell_users
        self._owners: dict[str, Client | None] = {}  # of every handle that can be taken
        self._shown = 0
        self._tasks: dict[asyncio.Task[None], Client] = {}
        self._listened_s = self._began_s = 0.0
        self.begin()

    def begin(self) -> None:
        """Begin anew with the session; handles stay whose they are."""
        users = self._session.description()["users"]
        remote = [user["name"] for user in users if user["remote"]]
        self._owners = {user: self._owners.get(user) for user in remote}
        self._held_s: dict[str, float] = {}  # of those whose hand is closed: newest target

    def holders(self, client: Client) -> list[dict[str, Any]]:
        """Return who holds which handle, as a page is told."""
        found = []
        for user in self._session.layout.users:  # to describe the session takes long
            owner = self._owners.get(user)
            holder = None if owner is None else "you" if owner is client else "other"
            found.append({"name": user, "holder": holder})
        return found

    def listened(self, time_s: float) -> None:
        """Note that pages were listened to for a time [s]; open the hands that got no target for
        too long of it.
        """
        self._listened_s += time_s
        for user, at_s in list(self._held_s.items()):
            if self._listened_s - at_s > SILENCE_S:
                self._open(user)

    def gone(self, client: Client) -> None:
        """Free the handles of a page that is gone."""
        for user in [user for user, owner in self._owners.items() if owner is client]:
            self._free(user)

    def _free(self, user: str) -> None:
        self._open(user)
        self._owners[user] = None
        self._tell_users()

    def _open(self, user: str) -> None:
        self._held_s.pop(user, None)
        self._session.target(user, None)

    def handle(self, client: Client, request: Request) -> None:
        """Do what a page asks for; answers that take their time come later."""
        session, kind, values = self._session, request.kind, request.values
        if kind == "seen":
            client.seen(values["seq"])
            self._shown += 1
            if self._shown == SETTLED:
                session.expect_questions()
        elif kind == "target":
            self._target(client, **values)
        elif kind not in session.can:
            self._answer(client, request, Answer(False, f"{kind}: not in this session"))
        elif kind == "take":
            why = self._take(client, values["user"])
            self._answer(client, request, Answer(not why, why))
            self._tell_users()
        elif kind == "let_go":
            mine = self._owners.get(values["user"]) is client
            if mine:
                self._free(values["user"])
            self._answer(client, request, Answer(mine, "" if mine else "not held by this page"))
        elif kind in ("set", "ask", "pause"):
            changes = kind != "ask"  # of questions the newest counts
            if changes and list(self._tasks.values()).count(client) >= MOST_AT_ONCE:
                text = f"{MOST_AT_ONCE} changes of this page are under way"
                self._answer(client, request, Answer(False, text))
                return
            task = asyncio.create_task(self._later(client, request))
            self._tasks[task] = client
            task.add_done_callback(self._tasks.pop)
        elif kind == "restart" and self._now_s() - self._began_s < AGAIN_S:
            text = f"it began less than {AGAIN_S:g} s ago"
            self._answer(client, request, Answer(False, text))
        else:
            if kind == "restart":
                self._began_s = self._now_s()
            self._answer(client, request, getattr(session, kind)(**values))

    def _take(self, client: Client, user: str) -> str:
        """Give a handle to a page; return why not, or ""."""
        if user not in self._owners:
            return f"{user}: has no handle that can be taken here"
        if self._owners[user] not in (None, client):
            return f"{user}: another page holds it"
        self._owners[user] = client
        return ""

    def _target(self, client: Client, user: str, position: tuple[float, ...] | None) -> None:
        if self._owners.get(user) is not client:
            return
        if position is None:
            self._open(user)
        else:
            self._held_s[user] = self._listened_s
            self._session.target(user, position)

    def _now_s(self) -> float:
        return asyncio.get_running_loop().time()

    async def _later(self, client: Client, request: Request) -> None:
        found = await getattr(self._session, request.kind)(**request.values)
        if request.kind != "ask":
            self._answer(client, request, found)
        elif found is None:
            self._answer(client, request, Answer(False, "a newer question came"))
        else:
            client.send({"kind": "prediction", "id": request.id, **found})

    def _answer(self, client: Client, request: Request, answer: Answer) -> None:
        if request.id is not None:
            client.send({"kind": "answer", "id": request.id, **answer._asdict()})
