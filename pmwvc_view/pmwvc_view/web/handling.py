# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of pages, carried out in the session and answered; who owns which handle."""

import asyncio
from collections.abc import Callable, Hashable, Sequence
from typing import Any

from pmwvc_view.controls import Settings
from pmwvc_view.protocol import SILENCE_S
from pmwvc_view.protocol.requests import Request
from pmwvc_view.session import Answer, Session
from pmwvc_view.web.client import Client

SETTLED = 64  # acknowledgements: what can wait begins, the page is there
MOST_AT_ONCE = 8  # changes of one page that are under way
AGAIN_S = 1.0  # between two beginnings


class Handles:
    """The owner of every handle that can be taken; one page at most."""

    def __init__(self, users: Sequence[str]) -> None:
        self._owners: dict[str, Hashable | None] = dict.fromkeys(users)
        self._held_s: dict[str, float] = {}  # of those whose hand is closed: newest target

    def take(self, user: str, page: Hashable) -> str | None:
        """Give a handle to a page; return why not, or None."""
        if user not in self._owners:
            return f"{user}: has no handle that can be taken here"
        if self._owners[user] not in (None, page):
            return f"{user}: another page holds it"
        self._owners[user] = page
        return None

    def owner(self, user: str) -> Hashable | None:
        """Return the page that a handle belongs to."""
        return self._owners.get(user)

    def owners(self) -> dict[str, Hashable]:
        """Return the owners of all handles that have one."""
        return {user: owner for user, owner in self._owners.items() if owner is not None}

    def owned(self, page: Hashable) -> list[str]:
        """Return the users whose handles belong to a page."""
        return [user for user, owner in self._owners.items() if owner == page]

    def free(self, user: str) -> None:
        """Take a handle back from its owner."""
        self._owners[user] = None
        self._held_s.pop(user, None)

    def held(self, user: str, now_s: float) -> None:
        """Note that the owner's hand is closed, and that a target came now [s]."""
        self._held_s[user] = now_s

    def opened(self, user: str) -> None:
        """Note that the owner's hand is open."""
        self._held_s.pop(user, None)

    def silent(self, now_s: float) -> list[str]:
        """Return the users whose closed hand got no target for too long, and open it."""
        found = [user for user, at_s in self._held_s.items() if now_s - at_s > SILENCE_S]
        for user in found:
            self.opened(user)
        return found


class Handling:
    """The requests of pages, answered; ``tell_users`` tells every page who owns which handle."""

    def __init__(self, session: Session, tell_users: Callable[[], None]) -> None:
        self._session, self._tell_users = session, tell_users
        self._handles = Handles(_remote(session))
        self._shown = 0
        self._tasks: dict[asyncio.Task[None], Client] = {}
        self._listened_s = self._began_s = 0.0

    def begin(self) -> None:
        """Begin anew with the session; handles stay whose they are."""
        before, self._handles = self._handles, Handles(_remote(self._session))
        for user, owner in before.owners().items():
            self._handles.take(user, owner)

    def holders(self, client: Client) -> list[dict[str, Any]]:
        """Return who holds which handle, as a page is told."""
        found = []
        for user in self._session.layout.users:  # to describe the session takes long
            owner = self._handles.owner(user)
            holder = None if owner is None else "you" if owner is client else "other"
            found.append({"name": user, "holder": holder})
        return found

    def listened(self, time_s: float) -> None:
        """Note that pages were listened to for a time [s]; open the hands that got no target for
        too long of it.
        """
        self._listened_s += time_s
        for user in self._handles.silent(self._listened_s):
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
            why = self._handles.take(values["user"], client)
            self._answer(client, request, Answer(why is None, why or ""))
            self._tell_users()
        elif kind == "let_go":
            mine = self._handles.owner(values["user"]) is client
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
        elif kind == "restart":
            self._answer(client, request, self._restart(values["values"]))
        else:
            go = session.seek if kind == "seek" else session.speed
            self._answer(client, request, go(**values))

    def _target(self, client: Client, user: str, position: tuple[float, ...] | None) -> None:
        if self._handles.owner(user) is not client:
            return
        if position is None:
            self._open(user)
        else:
            self._handles.held(user, self._listened_s)
            self._session.target(user, position)

    def _restart(self, values: Settings) -> Answer:
        now_s = asyncio.get_running_loop().time()
        if now_s - self._began_s < AGAIN_S:
            return Answer(False, f"it began less than {AGAIN_S:g} s ago")
        self._began_s = now_s
        return self._session.restart(values)

    async def _later(self, client: Client, request: Request) -> None:
        if request.kind != "ask":
            do = self._session.set if request.kind == "set" else self._session.pause
            self._answer(client, request, await do(**request.values))
            return
        found = await self._session.ask(**request.values)
        if found is None:
            self._answer(client, request, Answer(False, "a newer question came"))
        else:
            client.send({"kind": "prediction", "id": request.id, **found})

    def _answer(self, client: Client, request: Request, answer: Answer) -> None:
        if request.id is not None:
            client.send({"kind": "answer", "id": request.id, **answer._asdict()})


def _remote(session: Session) -> list[str]:
    return [user["name"] for user in session.description()["users"] if user["remote"]]
