# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The targets of remote hands from the recorded topics ``hand/target`` and ``hand/held``, as the
master took them: ``held: false`` lets go, and until ``held: true`` targets do not count.

A message's time is that of its publication, as long as it was received within ``TRUSTED_NS``
(else the clocks may differ, and it is that of its reception): the recorder may have to wait for
the processor longer than the master.
"""

import contextlib
from collections.abc import Iterable, Mapping

import numpy as np

from pmwvc_analysis.recording.format import schemas
from pmwvc_analysis.recording.salvage import RawMessage
from pmwvc_core.traces import HandTargets

TRUSTED_NS = 500_000_000
NOWHERE: tuple[float, ...] = (np.nan, np.nan, np.nan)


def is_of_hand(message: RawMessage) -> bool:
    """Tell whether a message is on one of the topics of a hand."""
    ends = {schemas.POINT: "/hand/target", schemas.FLAG: "/hand/held"}
    return message.topic.endswith(ends.get(message.type_name, "\0"))


def hand_targets(messages: Iterable[RawMessage], zero_ns: int) -> Mapping[str, HandTargets]:
    """Return the targets of every user that has any, by name."""
    found: dict[str, list[tuple[float, tuple[float, ...]]]] = {}
    counts: dict[str, bool] = {}
    for message in sorted(messages, key=_arrived_ns):
        user = message.topic.strip("/").split("/")[-3]
        point: tuple[float, ...] | None = None
        if message.type_name == schemas.FLAG:
            counts[user] = len(message.data) > 4 and bool(message.data[4])
            point = None if counts[user] else NOWHERE
        elif counts.get(user, True):
            with contextlib.suppress(Exception):  # no point: rosbags raises many kinds
                at = schemas.typestore().deserialize_cdr(message.data, schemas.POINT).point
                point = at.x, at.y, at.z
        if point is not None:
            time_s = (_arrived_ns(message) - zero_ns) * 1e-9
            found.setdefault(user, []).append((time_s, point))
    return {
        user: HandTargets(
            np.array([time_s for time_s, _ in rows]), np.array([point for _, point in rows])
        )
        for user, rows in found.items()
    }


def _arrived_ns(message: RawMessage) -> int:
    """Return when a message arrived at the master, as well as it is known [ns]."""
    waited = 0 <= message.log_ns - message.publish_ns < TRUSTED_NS
    return message.publish_ns if waited else message.log_ns
