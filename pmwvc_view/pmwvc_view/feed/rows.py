# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows of a session at given times, from its traces: the newest samples, the extremes of ticks,
the delays of links.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget.energy import UserEnergy
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_view.protocol.snapshot import CONTACTS, Layout

GONE_S = 0.5
DELAY_S = 0.5  # over which the delay of a link is the mean
ROUNDED_S = 1e-9
SIGNALS = ("x_m", "xd_m", "f_h", "f_applied", "u_m", "v_m")
AVATAR, OBJECT = ("x_s", "xd_s", "f_s"), ("x_o", "xd_o", "target")
WAYS = {"up": "up", "down": "down", "hand_port": "hand"}  # column by part of a user's energy


class Samples(NamedTuple):
    """Samples of a column: when they were taken [s], and their values ``(samples, ...)``; nothing
    is known where the newest is older than ``within_s``.
    """

    column: str
    time_s: Array
    values: NDArray[Any]
    within_s: float = GONE_S


def samples(traces: SessionTraces) -> Iterator[Samples]:
    """Yield what rows take from traces."""
    if (server := traces.server) is not None:
        for name in OBJECT:
            yield Samples(f"object.{name}", server.time_s, getattr(server, name))
        for body, poses in server.poses.items():
            yield Samples(f"{body}.pose", server.time_s, poses)
        yield Samples("contacts", server.time_s, touching(server))
        for index, user in enumerate(server.users):
            for name in (*AVATAR, "contact"):
                yield Samples(f"{user}.{name}", server.time_s, getattr(server, name)[index])
            yield Samples(f"{user}.presence", server.time_s, server.state[index])
    for one in traces.users:
        for name in SIGNALS:
            yield Samples(f"{one.name}.{name}", one.time_s, getattr(one, name))
        yield Samples(f"{one.name}.state", one.block_time_s, one.state)


def touching(server: ServerTraces) -> Array:
    """Return the strongest contacts of every step, ``(step, 6 * CONTACTS)``."""
    rows, first, second, *vectors = server.contacts.T
    step = rows.astype(int)
    place = np.arange(len(step)) - step.searchsorted(step)
    found = np.full((len(server.step), max(place.max(initial=0) + 1, CONTACTS), 6), math.nan)
    found[step, place] = np.transpose(vectors)
    on_second = (second >= 0) & ((first < 0) | (second < first))
    found[step, place, 3:] *= np.where(on_second, 1.0, -1.0)[:, None]
    return found[:, :CONTACTS].reshape(len(found), -1)


def energies(found: UserEnergy, least_j: Mapping[str, float]) -> Iterator[Samples]:
    """Yield a user's energies; ``least_j`` are the lowest balances before, by part."""
    for part, balance in found.parts.items():
        least = np.minimum.accumulate(balance.balance_j)
        least = np.minimum(least, min(least_j.get(part, 0.0), 0.0))
        amounts = balance.energy_in_j, balance.energy_out_j, least
        for name, values in zip(("in", "out", "min"), amounts, strict=True):
            column = f"{found.name}.energy_{WAYS[part]}_{name}"
            yield Samples(column, balance.time_s, values, math.inf)


def rows_of(
    times: Array,
    layout: Layout,
    found: Iterable[Samples],
    users: Iterable[UserTraces],
    links: Sequence[Array],
    shown_s: Mapping[str, float] | None = None,
) -> Array:
    """Return a row at each of some times [s], ``(rows, columns)``; NaN where nothing is known.
    ``links``: when packets were sent and arrived, ``(packets, 2)`` [s], in the order of snapshots;
    ``shown_s`` is the last tick of each user that a row before has shown.
    """
    rows = np.full((len(times), layout.size), math.nan)
    rows[:, 1] = times
    places: dict[tuple[int, float], Integers] = {}  # by series of times
    for column, time_s, values, within_s in found:
        if (where := layout.slices.get(column)) is None:
            continue  # a server may have had other users
        key = id(time_s), within_s
        if key not in places:
            places[key] = newest(time_s, times, within_s=within_s)
        known = places[key] >= 0
        rows[known, where] = values[places[key][known]].reshape(-1, where.stop - where.start)
    for user in users:
        _write_extremes(rows, layout, user, (shown_s or {}).get(user.name, -math.inf))
    for index, name in enumerate(layout.users):
        ways = [layout.slices[f"{name}.delay_{way}"] for way in ("up", "down")]
        for way, packets in zip(ways, links[2 * index : 2 * index + 2], strict=True):
            _write_delay(rows, way, packets)
        rows[:, layout.slices[f"{name}.round_trip"]] = sum(rows[:, way] for way in ways)
    return rows


def newest(of: Array, times: Array, *, within_s: float = math.inf) -> Integers:
    """Return the index of the newest sample at each time; -1: none, or older than ``within_s``."""
    at = of.searchsorted(times + ROUNDED_S, side="right") - 1
    if within_s < math.inf and len(of):
        at[times - of[at] > within_s] = -1
    return at


def _write_extremes(rows: Array, layout: Layout, user: UserTraces, shown_s: float) -> None:
    """Write the extremes of the ticks that no row has shown yet; late ones are the next row's."""
    at = newest(user.time_s, rows[:, 1])
    first = newest(user.time_s, np.array([shown_s]))
    before = np.maximum(np.concatenate([first, at[:-1]]), first)
    some = np.flatnonzero(at > before)
    if not len(some):
        return
    for name, signal, least in (
        ("f_min", user.f_applied, np.minimum),
        ("f_max", user.f_applied, np.maximum),
        ("lateness", user.lateness_s.reshape(-1, 1), np.maximum),
    ):
        extremes = least.reduceat(signal[: at[some[-1]] + 1], before[some] + 1, axis=0)
        rows[some, layout.slices[f"{user.name}.{name}"]] = extremes


def _write_delay(rows: Array, where: slice, packets: Array) -> None:
    """Write the mean delay of the packets that came out within ``DELAY_S`` before a row."""
    times, own = rows[:, 1], packets[np.isfinite(packets[:, 1])]
    own = own[np.argsort(own[:, 1], kind="stable")]
    sums = np.concatenate([[0.0], np.cumsum(own[:, 1] - own[:, 0])])
    last = own[:, 1].searchsorted(times, side="right")
    first = own[:, 1].searchsorted(times - DELAY_S, side="right")
    some = last > first
    mean = (sums[last] - sums[first])[some] / (last - first)[some]
    rows[some, where] = mean.reshape(-1, 1)
