# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The requests of pages, carried out in the session and answered; who owns which handle."""

import asyncio
from collections.abc import Callable, Hashable, Sequence
from typing import Any

from pmwvc_view.protocol import SILENCE_S, requests
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
            self._answer(client, request, Answer(mine, "" if mine else "not held by this page"))
        elif isinstance(request, requests.Set | requests.Ask | requests.Pause):
            changes = not isinstance(request, requests.Ask)  # of questions the newest counts
            if changes and list(self._tasks.values()).count(client) >= MOST_AT_ONCE:
                text = f"{MOST_AT_ONCE} changes of this page are under way"
                self._answer(client, request, Answer(False, text))
                return
            task = asyncio.create_task(self._later(client, request))
            self._tasks[task] = client
            task.add_done_callback(self._tasks.pop)
        else:
            self._answer(client, request, self._at_once(request))

    def _target(self, client: Client, request: requests.Target) -> None:
        if self._handles.owner(request.user) is not client:
            return
        if request.position is None:
            self._open(request.user)
        else:
            self._handles.held(request.user, self._listened_s)
            self._session.target(request.user, request.position)

    def _at_once(self, request: requests.Request) -> Answer:
        session = self._session
        if isinstance(request, requests.Restart):
            now_s = asyncio.get_running_loop().time()
            if now_s - self._began_s < AGAIN_S:
                return Answer(False, f"it began less than {AGAIN_S:g} s ago")
            self._began_s = now_s
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
            if found is None:
                self._answer(client, request, Answer(False, "a newer question came"))
            else:
                client.send({"kind": "prediction", "id": request.id, **found})

    def _answer(self, client: Client, request: Any, answer: Answer) -> None:
        if request.id is not None:
            client.send({"kind": "answer", "id": request.id, **answer._asdict()})


def _remote(session: Session) -> list[str]:
    return [user["name"] for user in session.description()["users"] if user["remote"]]
