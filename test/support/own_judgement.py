# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A judgement of a session from its raw traces, by other means than the product's.

*Twin*: a copy of the session, its devices kicked. Where the difference dies out the loop is no
source of the motion; hands and what they are given explain it. *Work*: -sum F dx over all devices
is what the loop gave the hands. What it gives at most at a stretch is held against all that can
have been stored. *Ports*: work of the device less the energy that the server counted.

``wrong_words`` compares that with what the summary, the terminal, the report and the page say.
"""

import copy
import itertools
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.law.user_tick import NEVER_NS
from pmwvc_core.scenario.names import over_time
from pmwvc_core.simulation.session import SteppedSession

KICK_M_S = 1e-5
DIES = 0.03  # of the kick, at the end
GROWN = 300.0  # times the kick, and a tenth of the motion
SEVERAL = 4.0  # times what can have been stored
LEAST_J = 0.01  # given by a loop that drives a motion
BLOWN_J = 0.1  # more than the steps of a sampled contact make in passing
TURNS = 8  # of a velocity while a loop gives energy: an oscillation and no single blow
MOVES_M_S = 5e-3
FAULT = 3  # state of a user whose force was switched off
SLACK = 1e-3  # of a balance: sums over ticks and over steps are cut off at different instants
UNSTABLE = ("sustained oscillation", "diverged")


class Own(NamedTuple):
    """What the traces of a session show."""

    finite: bool
    faulted: bool  # a force was switched off for good
    cut: bool  # a force was shortened or taken away in the second half
    dies_out: bool  # a kick, by the end
    grows: bool
    given_j: float  # by the loop to the hands, at a stretch
    turned: int  # how often the motion turned meanwhile
    stored_j: float  # most that can have been held
    hands_j: dict[str, float]  # least balance of each hand's port
    server_j: float  # least balance of the server
    blown_up: bool  # the object had more energy than the hands and the storage ever gave

    @property
    def drives(self) -> bool:
        """Whether the loop gave energy again and again."""
        return self.given_j > SEVERAL * self.stored_j + LEAST_J and self.turned >= TURNS

    @property
    def calm(self) -> bool:
        """Whether nothing but the hands moved the devices."""
        return self.dies_out and self.given_j <= self.stored_j + LEAST_J and not self.blown_up


def stepped(scenario, kick_at=0.4):
    """Return the traces of a session and of its twin: a copy of it whose devices get a kick after
    a share of its time.
    """
    session = SteppedSession(scenario)
    end_ns = session.ticks * session.tick_ns
    due = [(round(change.time_s * 1e9), new) for change, new in over_time(scenario)]
    kick_ns = round(kick_at * end_ns)
    go_on(session, [each for each in due if each[0] < kick_ns], kick_ns)
    session._steps, left = itertools.tee(session._steps)
    twin = copy.deepcopy(session, {id(session._steps): left})
    for number, user in enumerate(twin.users):
        state, kick = user.device.s, KICK_M_S / (1.0 + number)
        moved = {name: tuple(v + kick for v in getattr(state, name)) for name in ("xd", "read_xd")}
        user.device.s = state._replace(**moved)
    for each in (session, twin):
        go_on(each, [change for change in due if change[0] >= kick_ns], end_ns)
        each.advance(NEVER_NS)
        for user in each.users:
            user.up.drain(end_ns)
            user.down.drain(end_ns)
    return session.traces(), twin.traces()


def go_on(session, due, until_ns):
    """Step a session up to an instant, with the changes that are due before."""
    for at_ns, new in due:
        session.advance(min(at_ns, until_ns))
        session.change(new)
    session.advance(until_ns)


def own_judgement(scenario, traces, twin) -> Own:
    """Judge a session without what the product makes of it."""
    users, server = traces.users, traces.server
    signals = [np.concatenate([u.x_m, u.f_applied], axis=-1) for u in users] + [server.x_o]
    finite = all(np.isfinite(each).all() for each in signals)
    half = [user.time_s > 0.5 * traces.duration_s for user in users]
    pairs = list(zip(users, half, strict=True))
    cut = any(np.abs(u.f_applied - u.f_m)[rows].max(initial=0.0) > 1e-9 for u, rows in pairs)
    cut |= any((u.state[u.block_time_s > 0.5 * traces.duration_s] != 1).any() for u in users)
    known = {user.name: user for user in scenario.users}
    works = [np.cumsum(-np.sum(u.f_applied * _steps(u.x_m), axis=-1)) for u in users]
    ticks = min(map(len, works))
    given = np.sum([work[:ticks] for work in works], axis=0)
    rise = given - np.minimum.accumulate(given)
    last = int(np.argmax(rise))
    first = int(np.argmin(given[: last + 1]))
    turned = max(_turns(user.xd_m[first : last + 1]) for user in users)
    moving = sum(
        0.5 * known[u.name].device.mass * np.max(np.sum(u.xd_m**2, axis=-1)) for u in users
    )
    ports_j = sum(np.subtract(u, v) for u, v in _energies(server).values())
    declared = sum(_declared_j(scenario, user) for user in scenario.users)
    most_j = declared + max(float(ports_j.max()), 0.0)
    held_j = most_j  # a black box may not say how much it holds
    if not scenario.coupling.black_box:
        held_j = min(most_j, float(np.max(server.kinetic + server.potential)))
    return Own(
        finite,
        any((user.state == FAULT).any() for user in users),
        cut,
        *_twin(scenario, traces, twin),
        float(rise.max()),
        turned,
        held_j + float(moving) + declared,
        {user.name: _hand_j(user, server, work) for user, work in zip(users, works, strict=True)},
        float(ports_j.min()),
        float(np.max(server.kinetic)) > 2.0 * most_j + BLOWN_J,
    )


def _steps(x):
    return np.diff(x, axis=0, append=x[-1:])


def _turns(velocity):
    """Return how often a motion beyond ``MOVES_M_S`` turned."""
    axis = int(np.argmax(np.abs(velocity).max(axis=0)))
    fast = velocity[np.abs(velocity[:, axis]) > MOVES_M_S, axis]
    return int(np.sum(fast[1:] * fast[:-1] < 0.0))


def _energies(server):
    return dict(
        zip(server.users, zip(server.energy_u_s, server.energy_v_s, strict=True), strict=True)
    )


def _declared_j(scenario, user):
    if scenario.controller == "pspm":
        return 2.0 * user.baseline.pspm.initial_j
    lent = user.master.store_j + scenario.server.store_j if scenario.strict else 0.0
    return lent + user.master.position.storage_j


def _hand_j(user, server, work):
    """Return the least of what the device took and the server did not get."""
    u_s, v_s = _energies(server)[user.name]
    done = np.concatenate([[0.0], -work])
    at = np.clip(np.searchsorted(user.time_s, server.time_s - 1e-9), 0, len(work))
    return float(np.min(done[at] - (u_s - v_s)))


def _twin(scenario, traces, kicked):
    rows = slice(round(-0.5 / scenario.tick_s), None)
    end, motion = 0.0, 0.0
    for one, other in zip(traces.users, kicked.users, strict=True):
        end = max(end, float(np.abs(one.xd_m - other.xd_m)[rows].max()))
        motion = max(motion, float(np.abs(one.xd_m)[rows].max()))
    return end < DIES * KICK_M_S, end > GROWN * KICK_M_S and end > 0.1 * motion


def wrong_words(own: Own, found: dict[str, Any], *, exact: bool) -> list[str]:
    """Return which words of a summary the traces contradict; ``exact``: motion and force are what
    was recorded of them, without an encoder.
    """
    stable, kind, wrong = found["stable"], found["instability"], []
    if stable and not own.finite:
        wrong.append("stable, and not finite")
    if stable and own.faulted:
        wrong.append("stable, and a force was switched off")
    if stable and own.grows and own.drives:
        wrong.append("stable, and a kick grows")
    if stable and own.drives:
        wrong.append(f"stable, and the loop drove the hands with {own.given_j:.3g} J")
    if stable is not False and own.blown_up:
        wrong.append("not unstable, and the object had energy that nobody gave")
    if kind in UNSTABLE and own.calm and exact:
        wrong.append(
            f"{kind}, and a kick dies out in a loop that gave {own.given_j:.3g} J at most"
        )
    if kind == "limited by safety" and not own.cut and not own.faulted:
        wrong.append("limited by safety, and no force was shortened")
    if kind == "diverged" and found["passivity"]["passive"]:
        wrong.append("diverged, and passive")
    for port in found["passivity"]["ports"] if exact else ():
        if port["part"] not in ("hand_port", "server") or port["passive"] is None:
            continue
        least = own.server_j if port["part"] == "server" else own.hands_j[port["owner"]]
        allowed = port["declared_j"] + port["encoder_bound_j"] + 2.0 * port["tolerance_j"]
        slack = SLACK * max(abs(least), port["moved_j"])
        if least < -allowed - slack and port["passive"]:
            wrong.append(f"{port['owner']} passive, and its balance was {least:.3g} J")
        if least > -port["declared_j"] and not port["passive"]:
            wrong.append(f"{port['owner']} not passive, and its balance was {least:.3g} J")
    return wrong
