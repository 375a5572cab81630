# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on a session while it runs: one sentence, and a state in words per user.

It is as of now: what was recorded is judged by the report. Conditions stand in the sentence: since
when, which accounts, what was not judged. "Good" says that all are coupled, that every account was
judged and passive, and that the report's judge finds nothing unstable in the newest seconds, since
a parameter changed at the earliest. Notices beside it tell what explains what is seen.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pmwvc_analysis.budget.energy import declared_j
from pmwvc_analysis.events import grips
from pmwvc_analysis.traces.felt import felt, felt_words
from pmwvc_analysis.verdicts import stability
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces, loads
from pmwvc_core.words import quantity
from pmwvc_view.feed.feed import Feed, FeedUser
from pmwvc_view.feed.tape import SPAN_S, Tape

JUDGED_S = 1.0  # between two judgements
LATE_S = 1.0  # newest part, in which a force is at its limit or not
AT_LIMIT = 0.999


class Judge:
    """The report's judge on the newest seconds. ``why`` tells what makes the session unstable as
    of now, empty: nothing does; ``was`` what did last, and until when; ``slips`` what slipped or
    fell; ``limited`` which force or torque is at its largest; ``felt``: what each user felt.
    """

    def __init__(self, tape: Tape, scene: Mapping[str, Any]) -> None:
        self._tape, self._scene = tape, scene
        self._since_s, self._judged_s = -math.inf, -JUDGED_S
        self.why, self.was, self.slips = "", list[str](), list[str]()
        self.limited, self.felt = list[str](), dict[str, str]()

    def changed(self) -> None:
        """Begin anew: what was before a change of parameters says nothing of what is."""
        self._since_s = self._tape.end_s

    def judge(self, scenario: Scenario) -> None:
        """Judge what is new, now and then; the scenario is that of now. What goes on is judged
        over the newer half of what is kept.
        """
        now_s = self._tape.end_s
        if now_s < self._judged_s + JUDGED_S:
            return
        self._judged_s, now = now_s, replace(scenario, changes="")
        traces = self.traces(now)
        found = stability.verdict(traces, now, since_s=now_s - 0.5 * SPAN_S)
        unstable = f"{found.instability}: {found.why}" if found.stable is False else ""
        if self.why and not unstable:
            self.was = [f"Not stable until {now_s:.0f} s, {self.why}."]
        self.why, self.limited = unstable, []
        seen = grips.events(traces.server, now, self._scene)
        self.slips = [f"{e['who']}, at {e['time_s']:.2f} s: {e['what']}." for e in seen]
        safety = {user.name: user.safety for user in scenario.users}
        for own in traces.users:
            limits = safety[own.name]
            torque_n_m = limits.torque_n_m(now.server.lever_m)
            most = {"force": limits.max_force, "torque": torque_n_m}
            for load, unit, f in loads(own.f_applied[own.time_s > now_s - LATE_S], now):
                size = np.linalg.norm(f, axis=-1)
                if size.size and np.mean(size >= AT_LIMIT * most[load]) > 0.5:
                    self.limited.append(f"{load} of {own.name} ({most[load]:.3g} {unit})")
            self.felt[own.name] = felt_words(felt(traces, own, now)._asdict())

    def traces(self, scenario: Scenario) -> SessionTraces:
        """Return what is judged."""
        return self._tape.judged(scenario, max(self._since_s, self._tape.end_s - SPAN_S))


GOOD, CAUTION, BAD, UNKNOWN = "good", "caution", "bad", "unknown"


def verdict(
    feed: Feed,
    judge: Judge,
    scenario: Scenario,
    *,
    exact_hands: Collection[str],
    notices: Sequence[str],
) -> dict[str, Any]:
    """Return the text message: verdict, level, users, notices, which are what people should know
    beside the verdict. ``exact_hands``: users whose device counts its true motion, as a simulated
    one does whatever its encoder shows; their account at the port of the hand is judged.
    """
    level, sentence = _judged(feed, judge, scenario, exact_hands)
    if scenario.coupling.black_box and level == GOOD:
        level, sentence = UNKNOWN, f"{sentence} What its port withholds is judged by the report."
    states = {}
    for name, user in feed.users.items():
        word = "no data" if user.state is None else SafetyState(user.state).name.lower()
        note = "; ".join(filter(None, (user.kept_apart, _left_out(user))))
        felt_by = judge.felt.get(name, "")
        states[name] = {"state": word, "reason": user.reason, "note": note, "felt": felt_by}
    texts = [*notices, *judge.was, *judge.slips]
    return {"verdict": sentence, "level": level, "users": states, "notices": texts}


def _judged(
    feed: Feed, judge: Judge, scenario: Scenario, exact: Collection[str]
) -> tuple[str, str]:
    users = feed.users
    faults = [f"{name}: {u.reason}" for name, u in users.items() if u.state == SafetyState.FAULT]
    off = [f"Force switched off: {'; '.join(faults)}"] if faults else []
    unstable = [f"Not stable, {judge.why}"] if judge.why and not faults else []
    active = "; ".join(_active(feed, exact))
    passive = [f"Not passive: {active}"] if active else []
    if bad := [*off, *unstable, *passive]:
        return BAD, f"{'. '.join(bad)}."
    if waiting := [
        f"{name} {_waits(u)}" for name, u in users.items() if u.state != SafetyState.COUPLED
    ]:
        return CAUTION, f"Not all users are coupled: {'; '.join(waiting)}."
    if judge.limited:
        return CAUTION, f"All users are coupled; at its limit: {', '.join(judge.limited)}."
    unjudged = [n for n, u in users.items() if not (u.known and (u.channel_known or n in exact))]
    if unjudged:
        return UNKNOWN, f"All users are coupled; energy is not judged for {', '.join(unjudged)}."
    channels = all(user.channel_known for user in users.values())
    parts = "no channel" if channels else "no user's link"
    sentence = f"All users are coupled; {parts} has given out more energy than it received"
    lent_j = max(declared_j(scenario, user) for user in scenario.users)
    if lent_j > 0.0:
        sentence += f" and was lent at the start ({quantity(lent_j, 'J')} at most)"
    inexact = [name for name in users if name not in exact]
    if inexact:
        return UNKNOWN, (
            f"{sentence}. Energy at the hand is not judged here for {', '.join(inexact)}; the "
            "report judges it as far as the encoder allows."
        )
    return GOOD, f"{sentence}."


def _waits(user: FeedUser) -> str:
    if user.state is None:
        return "sends nothing any more" if user.gone else "has sent nothing yet"
    why = f" ({user.reason})" if user.reason else ""
    return f"is {SafetyState(user.state).name.lower()}{why}"


def _active(feed: Feed, exact: Collection[str]) -> list[str]:
    """Return the accounts that were below what they may be, in words."""
    return [
        f"{f'{found.owner}, ' if found.owner in feed.users else ''}{found.words}, gave out "
        f"{quantity(found.given_j, 'J')} more than it received (at {found.least_s or 0.0:.1f} s)"
        for found in feed.worst.values()
        if found.passive is False and (found.part != "hand_port" or found.owner in exact)
    ]


def _left_out(user: FeedUser) -> str:
    """Return what the energy account of a user does not cover."""
    if not user.judged:
        return "a node was started again: its energy is no longer judged"
    return "" if user.known else "no energy account yet"
