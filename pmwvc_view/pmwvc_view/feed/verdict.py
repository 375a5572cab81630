# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on a session while it runs: one sentence, and a state in words per user.

It is as of now: what was recorded is judged by the report. Conditions stand in the sentence: since
when, which accounts, what was not judged. "Good" says that all are coupled, that every account was
judged and passive, and that the report's judge finds nothing unstable in the newest seconds.

Notices beside it tell what happened to a running session that explains what is seen.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import quantity
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.traces import NS
from pmwvc_view.feed.user import FeedUser
from pmwvc_view.protocol.snapshot import Layout, Snapshot

STALL_S = 0.025  # of a loop: it then skips ticks, and a watchdog of 30 ms may let go
MOST = 4


class Notices:
    """The newest notices of a session."""

    def __init__(self) -> None:
        self._texts: deque[str] = deque(maxlen=MOST)
        self._time_s = 0.0

    def texts(self) -> list[str]:
        """Return the notices, oldest first."""
        return list(self._texts)

    def watch(self, snapshots: Sequence[Snapshot], layout: Layout, users: Sequence[str]) -> None:
        """Note the stalls of force loops in new snapshots."""
        for snapshot in snapshots:
            row = snapshot.row
            self._time_s = float(row[layout.slices["time_s"].start])
            for user in users:
                late_s = float(row[layout.slices[f"{user}.lateness"].start])
                if late_s > STALL_S:  # not where it is not known
                    self._note(
                        f"the machine stalled: the force loop of {user} woke "
                        f"{1e3 * late_s:.0f} ms late; beyond 30 ms its force and avatar begin anew"
                    )

    def changed(self, old: Scenario, new: Scenario) -> None:
        """Note a delay that grows under waves; samples of waves are held meanwhile."""
        pairs = [
            (getattr(before, way).delay_s, getattr(after, way).delay_s)
            for before, after in zip(old.users, new.users, strict=True)
            for way in ("link_up", "link_down")
        ]
        if has_waves(new.controller) and any(after > before for before, after in pairs):
            longest_s = max(after for _, after in pairs)
            text = f"the delay grew, to {1e3 * longest_s:.0f} ms"
            if new.channel == "plain":
                text += "; meanwhile waves are held, which can generate energy"
            self._note(text)

    def _note(self, text: str) -> None:
        self._texts.append(f"At {self._time_s:.1f} s {text}.")


WORDS = ("starting", "coupled", "damping", "fault")
GOOD, CAUTION, BAD, UNKNOWN = "good", "caution", "bad", "unknown"


def verdict(
    feed: Feed,
    users: Sequence[str],
    *,
    storage_j: Mapping[str, float],
    exact_hands: Sequence[str],
    notices: Sequence[str],
) -> dict[str, Any]:
    """Return the text message: verdict, level, users, notices.

    Parameters
    ----------
    storage_j
        Energy that a user's controller was declared to hold at the start [J].
    exact_hands
        Users whose device counts its true motion, as a simulated one does whatever its encoder
        shows: their account from hand to object is judged.
    notices
        What people should know beside the verdict.
    """
    level, sentence = _judged(feed, users, storage_j, exact_hands)
    states, earlier = {}, []
    for user in users:
        known = feed.user(user)
        word = "no data" if known.state is None else WORDS[known.state]
        note = "; ".join(filter(None, (known.kept_apart, _left_out(known))))
        states[user] = {"state": word, "reason": known.reason, "note": note}
    why, until_s = feed.window.was
    if why:
        earlier.append(f"Not stable until {until_s:.0f} s, {why}.")
    return {"verdict": sentence, "level": level, "users": states, "notices": [*notices, *earlier]}


def _judged(
    feed: Feed, users: Sequence[str], storage_j: Mapping[str, float], exact: Sequence[str]
) -> tuple[str, str]:
    known = {user: feed.user(user) for user in users}
    faults = [
        f"{u}: {each.reason}" for u, each in known.items() if each.state == SafetyState.FAULT
    ]
    if faults:
        return BAD, f"Force switched off: {'; '.join(faults)}."
    active = _active(feed, users, storage_j, exact)
    unstable = [f"Not stable, {feed.window.why}"] if feed.window.why else []
    if active or unstable:
        passive = [f"Not passive: {'; '.join(active)}"] if active else []
        return BAD, f"{'. '.join(unstable + passive)}."
    waiting = [
        f"{user} {_waits(each)}"
        for user, each in known.items()
        if each.state != SafetyState.COUPLED
    ]
    if waiting:
        return CAUTION, f"Not all users are coupled: {'; '.join(waiting)}."
    limited = [f"{user} ({force:.3g} N)" for user, force in feed.window.limited.items()]
    if limited:
        return CAUTION, f"All users are coupled; force at its limit: {', '.join(limited)}."
    unjudged = [
        user
        for user, each in known.items()
        if not (each.accounts.known_ns is not None and each.accounts.judged)
        or not (each.channel_known or user in exact)
    ]
    if unjudged:
        return UNKNOWN, f"All users are coupled; energy is not judged for {', '.join(unjudged)}."
    channels = all(each.channel_known for each in known.values())
    parts = "no channel" if channels else "no user's link"
    sentence = f"All users are coupled; {parts} has given out more energy than it received"
    lent_mj = 1e3 * max((storage_j.get(user, 0.0) for user in users), default=0.0)
    if lent_mj > 0.0:
        sentence += f" and was lent at the start ({quantity(lent_mj / 1e3, 'J')} at most)"
    inexact = [user for user in users if user not in exact]
    if inexact:
        return UNKNOWN, (
            f"{sentence}. Energy at the hand is not judged here for {', '.join(inexact)}; the "
            "report judges it as far as the encoder allows."
        )
    return GOOD, f"{sentence}."


def _waits(user: FeedUser) -> str:
    if user.state is None:
        return "sends nothing any more" if user.gone else "has sent nothing yet"
    return f"is {WORDS[user.state]}" + (f" ({user.reason})" if user.reason else "")


def _active(
    feed: Feed, users: Sequence[str], storage_j: Mapping[str, float], exact: Sequence[str]
) -> list[str]:
    """Return the accounts that were below what they may be, in words."""
    found = []
    for user in users:
        accounts = feed.user(user).accounts
        parts = [("way up", accounts.up), ("way down", accounts.down)]
        if user in exact:
            parts.append(("hand to object", accounts.hand))
        for name, account in parts:
            if account.margin_j < -storage_j.get(user, 0.0):
                at_s = (account.least_ns - (feed.zero_ns or 0)) / NS
                found.append(
                    f"{user}, {name}, gave out {quantity(-account.least_j, 'J')} more than it "
                    f"received (at {at_s:.1f} s)"
                )
    return found


def _left_out(user: FeedUser) -> str:
    """Return what the energy account, or the distance, of a user does not cover."""
    if user.accounts.known_ns is None:
        return "no energy account yet"
    if not user.accounts.judged:
        return "a node was started again: its energy is counted and no longer judged"
    if user.loaded_change:
        return (
            "delay or impedance changed under load: until it is coupled anew, the distance to the "
            "avatar need not be F tau/2b"
        )
    return ""
