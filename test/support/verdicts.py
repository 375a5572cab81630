# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdicts on a live session that hold whatever its machine does; a failure says why."""

import numpy as np

from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.recording.topics import relayed
from pmwvc_analysis.traces.arrivals import waited
from pmwvc_analysis.traces.thresholds import UNEVEN
from support.excuses import unless_stalled

LATE_S = 0.01  # of a loop: it stood still


def loops_stood_still(traces, users) -> bool:
    """Tell whether the loop of the server, or of one of these users, stood still."""
    late_s = [np.max(traces.metadata["server_lateness_s"])]
    late_s += [user.lateness_s.max() for user in users]
    return any(user.missed for user in users) or max(late_s) > LATE_S


def stood_still(session) -> bool:
    """Tell whether a loop of the session stood still, or packets came late."""
    traces = read_session(session.folder)
    links = [packets for topic, packets in traces.packets.items() if relayed(topic)]
    late = waited(links, 0.0, traces.duration_s) > UNEVEN
    return late or loops_stood_still(traces, traces.users)


def judged_stable(session) -> None:
    """Stable; not judged where the machine stood still, which is no answer."""
    found = session.summary()
    with unless_stalled(lambda: found["stable"] is None and stood_still(session)):
        assert found["stable"] is True, (found["instability"], found["stability"]["text"])


def judged_passive(session, only_users: bool = False) -> None:
    """Every port is passive, less what the force held while a master stood still gave its hand.

    ``only_users``: of a controller that promises nothing of the server. One that couples to the
    object as sampled gives out some energy of the step, more so where packets come unevenly.
    """
    given_j = {user.name: given_while_still_j(user) for user in read_session(session.folder).users}
    found = session.summary()["passivity"]
    for port in found["ports"]:
        if only_users and port["owner"] not in given_j:
            continue
        allowed_j = port["tolerance_j"] + given_j.get(port["owner"], 0.0)
        assert port["passive"] or port["least_balance_j"] >= -allowed_j, (port, found["text"])


def given_while_still_j(user) -> float:
    """Return the energy that the last force gave over ticks that were missed [J]."""
    rows = np.flatnonzero(np.diff(user.tick) > 1)
    taken = np.sum(user.f_applied[rows] * (user.x_m[rows + 1] - user.x_m[rows]), axis=-1)
    return float(np.maximum(-taken, 0.0).sum())
