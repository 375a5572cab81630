# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What every controller does at the master's end, in the order of a frame and of a tick, and what
it sees of the device.

A member is chosen by the type of its state. ``p`` are the parameters of the port. What has come in
(``arrivals``) belongs to the tick; the strict channel plays its waves out from there.

A sample that is too old, or none, is no sample: the loop has the position last seen and no
velocity, and the limits let no force through.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family, same
from pmwvc_core.law.vectors import Vector, each, zero


def _waves(s: Any) -> Any:
    return s.waves


port_measure = Family("port_measure")  # (s, x, xd, p) -> s: motion at a frame start
# (s, arrivals, frame_s, number, held_j, p) -> (s, arrivals, Sent); held_j: what the brake stores
port_send = Family("port_send")
port_packet = Family("port_packet")  # (s, arrivals, packet, p) -> s: the newest, once a frame
port_answer = Family("port_answer")  # (s, wave, silent, frame_s, p) -> s: its wave, or a silence
port_tick = Family("port_tick")  # (s, arrivals, x, xd, p) -> (s, arrivals, force wanted [N])
port_applied = Family("port_applied")  # (s, f, p) -> s: with the force that the limits let through
port_signals = Family("port_signals", _waves)  # (s) -> (u_m, u_m_lp, v_m)
# (s, arrivals, p) -> energies since the start [J]: of u_m, sent, received, v_m, and the port's own
port_energies = Family("port_energies")
port_opened = Family("port_opened", same)  # (s) -> s: lists made here, where a session is compiled


LATE_NS = 5_000_000  # a sample older than this is counted
STALE_NS = 20_000_000  # one older than this is none: the device is silent
NEVER_NS = -(1 << 62)


class Sample(NamedTuple):
    """What a device says at a tick."""

    x: Vector  # [m]
    xd: Vector  # [m/s]
    valid: bool  # position and velocity can be trusted
    measured_ns: int  # when; NEVER_NS where nothing new came since the last sample


def age_ns(sample: Sample, measured_ns: int, now_ns: int) -> float:
    """Return how old a sample is, the newest before having been taken at ``measured_ns``; infinite
    where it is none.
    """
    old = now_ns - max(measured_ns, sample.measured_ns)
    return float(old) if sample.valid and old >= 0 else math.inf


def known_motion(x: Vector, xd: Vector, last: Vector) -> tuple[Vector, Vector]:
    """Return position and velocity; what is not finite counts as the last position and as no
    velocity.
    """
    for i in range(len(x)):
        if not math.isfinite(x[i] + xd[i]):
            return each(_finite, (x, last)), each(_finite, (xd, zero(xd)))
    return x, xd


def _finite(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise
