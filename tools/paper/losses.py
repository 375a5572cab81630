# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figure: the force in a hand while packets are lost: 10 % of both ways while two hands carry a
cube, and five in a row on the way down while they hold it. 16 ms each way, 125 packets a second.
Every session is compared with the same one without losses.
"""

import math

import numpy as np

from paper.drawing import COLOURS, Rows, panels, save
from paper.links import Array
from pmwvc_analysis.compare.measures import coherency_m
from pmwvc_bringup import scenarios as files
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

NAME = "losses"
NO_STORE = ("master.store_j=0", "server.store_j=0")
CHANNELS = (  # what is drawn, and its settings
    ("strict, with concealment", ("channel=strict",)),
    ("strict, nothing stored", ("channel=strict", *NO_STORE)),
    ("plain (hold the last)", ("channel=plain",)),
    ("zeroing", ("channel=zeroing",)),
)
BURST_S, LOST_S = 5.0, 0.04  # five packets of 8 ms
NETWORKS = (  # title, settings, part shown
    ("carried, 10 % of packets lost", ("link.loss=0.1",), (4.0, 9.0)),
    (
        "held, five packets lost in a row",
        ("task.kind=hold", f"link.down.schedule={BURST_S} outage; {BURST_S + LOST_S} base"),
        (BURST_S - 0.1, BURST_S + 0.4),
    ),
)
SETTLED_S, DURATION_S = 4.0, 12.0
LOSSES = ("link.loss", "link.down.schedule")


def session(channel: tuple[str, ...], network: tuple[str, ...]) -> SessionTraces:
    """Return a session."""
    texts = ("seed=1", *network, *channel)
    return simulate_one(files.load("carry_16ms", settings_texts=texts, duration_s=DURATION_S))


def force_of(traces: SessionTraces) -> Array:
    """Return the force of the first user against its hand [N]."""
    user = traces.users[0]
    force = user.f_applied[:, 0]
    return np.asarray(force * np.sign(force[user.time_s >= SETTLED_S].mean() or 1.0))


def make() -> Rows:
    """Draw, and return the numbers."""
    figure, axes = panels(len(CHANNELS), 2, 5.2, sharex="col", sharey=True)
    numbers = [["receiver", *(title for title, _, _ in NETWORKS)]]
    numbers += [[label] for label, _ in CHANNELS]
    for column, (title, network, (begin_s, end_s)) in enumerate(NETWORKS):
        for row, (label, channel) in enumerate(CHANNELS):
            traces = session(channel, network)
            whole = tuple(text for text in network if not text.startswith(LOSSES))
            force, time_s = force_of(traces), traces.users[0].time_s
            undisturbed = force_of(session(channel, whole))
            late = time_s >= SETTLED_S
            place = axes[2 * row + column]
            shown = (time_s >= begin_s) & (time_s <= end_s)
            place.plot(time_s[shown], undisturbed[shown], color="0.6", ls="--", lw=1.0)
            place.plot(time_s[shown], force[shown], color=COLOURS[row])
            place.set(ylabel="force [N]" if column == 0 else None)
            place.set_title(f"{title}\n{label}" if row == 0 else label)
            off = (force - undisturbed)[late]
            step = np.abs(np.diff(force[late])).max()
            apart_m = coherency_m(traces)
            offset_mm = math.nan if apart_m is None else 1e3 * apart_m
            rms = np.sqrt(np.mean(off**2))
            numbers[1 + row].append(f"{step:.2f} N, {rms:.3f} N, {offset_mm:.2f} mm")
    for place in axes[-2:]:
        place.set(xlabel="time [s]")
    save(figure, NAME)
    return numbers
