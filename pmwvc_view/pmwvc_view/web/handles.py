# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The handles of a session: who holds which, and who lets go by being silent."""

from collections.abc import Hashable, Sequence

from pmwvc_view.protocol import SILENCE_S


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
            return f"{user}: somebody else has taken hold of it"
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
