# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the network in virtual time: a cube is carried meanwhile, on the strict channel."""

import functools
import math
from collections.abc import Callable

import numpy as np

from faults.fault import Fault, Outcome, joined, undisturbed
from faults.lags import WatchedBatch, fitted_s
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_core.frame import Presence
from pmwvc_core.law.channel.constants import OUTAGE_S
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.effects import mean_s
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.simulation.conditions import SimulatedLink
from pmwvc_core.transport.packet import Receipt
from pmwvc_core.wave.impedance import first_axis

DURATION_S = 18.0
CALM = ("link.delay_s=0.016",)
PEAK = 1.5  # of the undisturbed session
SPARE_M = 1e-3
DAMPED_S = OUTAGE_S + 0.05  # at both ends, of the outages that brakes answer


class Carried:
    """One simulated session of two hands that carry a cube, and its summary."""

    def __init__(self, settings: tuple[str, ...], channel: str = "strict") -> None:
        words = [f"channel={channel}", f"duration_s={DURATION_S:g}", *settings]
        self.scenario = scenarios.load("carry_16ms", settings_texts=words)
        self.batch = WatchedBatch(self.scenario)
        self.batch.run(lambda ratio: None)
        self.traces = self.batch.traces()
        self.summary = summary(self.traces, self.scenario)

    @property
    def passive(self) -> bool:
        """Tell whether every user's port is passive."""
        return all(user["passive"] for user in self.summary["users"])

    @property
    def peak_n(self) -> float:
        """Return the largest force on a hand after the grip has settled [N]."""
        late = [np.abs(u.f_applied[u.time_s > 2.0]).max() for u in self.traces.users]
        return float(max(late))

    def offset_m(self, since_s: float, until_s: float = DURATION_S) -> float:
        """Return the largest distance of a device from its avatar in a time [m]."""
        server, found = self.traces.server, []
        assert server is not None
        rows = (server.time_s >= since_s) & (server.time_s < until_s)
        for user, x_s in zip(self.traces.users, server.x_s, strict=True):
            x_m = np.interp(server.time_s[rows], user.time_s, user.x_m[:, 0])
            found.append(np.abs(x_m - x_s[rows, 0]).max())
        return float(max(found))

    @property
    def nominal_s(self) -> float:
        """Return T1 + T2 of the mean delays and the frames [s]."""
        user = self.scenario.users[0]
        return mean_s(user.link_up) + mean_s(user.link_down) + 2.0 * user.master.frame_s

    def bound_m(self) -> float:
        """Return F (T1 + T2)/(2b) of the nominal T, and 1 mm [m]."""
        force = max(abs(each["force_final_n"]) for each in self.summary["users"])
        return self._spring_m(force, self.nominal_s) + SPARE_M

    def _spring_m(self, force: float, round_trip_s: float) -> float:
        return force * round_trip_s / (2.0 * first_axis(self.scenario.users[0].impedance))

    def apart(self) -> tuple[bool, str]:
        """Tell whether every device was within F (T1 + T2)/(2b) + 1 mm of its avatar in the last
        second on average, for the T that waves took and the mean force.
        """
        server, found = self.traces.server, []
        assert server is not None
        rows = server.time_s >= DURATION_S - 1.0
        for i, (user, x_s) in enumerate(zip(self.traces.users, server.x_s, strict=True)):
            took_s = self.batch.reported_s(i, rows)
            x_m = np.interp(server.time_s[rows], user.time_s, user.x_m[:, 0])
            off_m = float(np.abs(x_m - x_s[rows, 0]).mean())
            force = float(np.abs(user.f_applied[user.time_s >= DURATION_S - 1.0]).mean())
            spare_m = self._spring_m(force, took_s) + SPARE_M - off_m
            found.append((spare_m, off_m, took_s, fitted_s(self.traces, i)))
        spare_m, off_m, took_s, fit_s = min(found)
        return spare_m >= 0.0, (
            f"offset {1e3 * off_m:.1f}, at most {1e3 * self.offset_m(DURATION_S - 1.0):.1f} mm "
            f"(allowed {1e3 * (off_m + spare_m):.1f} at T = {1e3 * took_s:.0f} ms, fit "
            f"{1e3 * fit_s:.0f}; {1e3 * self.bound_m():.1f} at nominal "
            f"{1e3 * self.nominal_s:.0f})"
        )

    def damped_s(self, after_s: float) -> tuple[float, float]:
        """Return how long after a time all have only damping at one of the ends, force loops or
        avatars, and at both [s].
        """
        server = self.traces.server
        assert server is not None
        avatars = [(server.time_s, state, Presence.DAMPING) for state in server.state]
        devices = [(u.block_time_s, u.state, SafetyState.DAMPING) for u in self.traces.users]
        found = []
        for end in (avatars, devices):
            begins = []
            for time_s, state, damping in end:
                times_s = time_s[(time_s >= after_s) & (np.ravel(state) == damping)]
                begins.append(float(times_s[0]) - after_s if len(times_s) else np.inf)
            found.append(max(begins))
        one, both = sorted(found)
        return one, both


@functools.cache
def carried(*settings: str, channel: str = "strict") -> Carried:
    """Return a session, simulated once."""
    return Carried(settings, channel)


def _balance(session: Carried) -> tuple[bool, str]:
    return session.passive, "passive" if session.passive else "not passive"


def _plainly(*settings: str) -> str:
    if any(text.startswith("changes=") for text in settings):
        return "`plain` refuses the change"
    plain = carried(*settings, channel="plain")
    word = "passive" if plain.passive else "not passive"
    offset = 1e3 * plain.offset_m(DURATION_S - 1.0)
    return f"`plain`: {word}, {offset:.1f} mm"


def carries(*settings: str, ends: bool = False) -> Outcome:
    """Return what a disturbance does: energy, distance at the end, peak force.

    One that ``ends`` must leave nothing behind: there the distance is judged with the nominal T.
    """
    session, calm = carried(*settings), carried(*CALM)
    held, apart = session.apart()
    if ends:
        held = session.offset_m(DURATION_S - 1.0) <= session.bound_m()
    ratio = session.peak_n / calm.peak_n
    return joined(
        _balance(session),
        (held, apart),
        (ratio <= PEAK, f"peak {ratio:.2f}"),
        undisturbed(session.summary),
        (True, _plainly(*settings)),
    )


def outage(begin_s: float, end_s: float, *where: str) -> Outcome:
    """Return what an outage does: damping, the way back, and no drift after it."""
    settings = tuple(f"{link}.schedule={begin_s} outage; {end_s} base" for link in where)
    settings = (*CALM, *settings)
    session, calm = carried(*settings), carried(*CALM)
    _, damped_s = session.damped_s(begin_s)
    back_m, allowed_m = session.offset_m(end_s + 1.0, end_s + 2.0), session.bound_m()
    last_m = session.offset_m(DURATION_S - 1.0)
    calm_m = calm.offset_m(DURATION_S - 1.0)
    holding = min(abs(user["force_final_n"]) for user in session.summary["users"])
    return joined(
        _balance(session),
        (
            damped_s <= DAMPED_S or end_s - begin_s < OUTAGE_S,
            f"damping at both ends after {1e3 * damped_s:.0f} ms"
            if math.isfinite(damped_s)
            else "concealed, without damping",
        ),
        (
            back_m <= allowed_m,
            f"offset {1e3 * back_m:.1f} mm 1 to 2 s after the end (allowed {1e3 * allowed_m:.1f})",
        ),
        (
            last_m <= calm_m + SPARE_M,
            f"{1e3 * last_m:.1f} mm in the last second (undisturbed {1e3 * calm_m:.1f})",
        ),
        (
            session.peak_n <= PEAK * calm.peak_n,
            f"peak {session.peak_n / calm.peak_n:.2f}",
        ),
        undisturbed(session.summary),
        (True, f"final force {holding:.2f} N"),
        (True, _plainly(*settings)),
    )


def done_by(way: SimulatedLink, verdict: Receipt) -> int:
    """Return how many packets a link repeated, corrupted or had overtaken."""
    if verdict is Receipt.REORDERED:
        numbers = np.array([packet.seq for packet, _ in way.arrived])
        return int((numbers < np.maximum.accumulate(numbers)).sum())
    if verdict is Receipt.DUPLICATE:
        return sum(fate.kind is FateKind.DUPLICATE for fate in way.fates)
    return sum(fate.cause is Cause.CORRUPTION for fate in way.fates)


def counted(link: str, verdict: Receipt, *settings: str) -> Outcome:
    """Return whether the receivers count what the links did, and the session holds."""
    session = carried(*CALM, "link.keep_order=false", *settings)
    seen, done = 0, 0
    for user in session.batch.users:
        for way in (user.up, user.down):
            seen += way.receiver.counts[verdict]
            done += done_by(way, verdict)
    under_way = sum(
        way.link.counters.queued for user in session.batch.users for way in (user.up, user.down)
    )
    before = carries(*CALM, "link.keep_order=false", *settings)
    same = 0 <= done - seen <= under_way
    text = f"{done} {link}, {seen} counted"
    if under_way:
        text += f" ({under_way} in flight)"
    return joined((same, text), (before.held, before.seen))


def _outage(*links: str, length_s: float) -> Callable[[], Outcome]:
    return lambda: outage(6.0, 6.0 + length_s, *links)


ALL = ("link",)
SESSIONS = (
    Fault(
        "F05a",
        "uplinks lost for 0.5 s",
        "damping within 0.15 s, offset within the bound 1 s later, no drift",
        _outage("link.up", length_s=0.5),
    ),
    Fault("F05b", "both directions lost for 0.05 s", "as F05a", _outage(*ALL, length_s=0.05)),
    Fault("F05c", "both directions lost for 2 s", "as F05a", _outage(*ALL, length_s=2.0)),
    Fault(
        "F05d",
        "both directions lost for 0.3 s of every second",
        "passive, no drift, peak at most 1.5, no step",
        lambda: carries(*CALM, "link.schedule=0.7 outage; 1 repeat"),
    ),
    Fault(
        "F08a",
        "three of ten packets overtake others",
        "counted as injected, and as F05d",
        lambda: counted("reordered", Receipt.REORDERED, "link.reorder=0.3"),
    ),
    Fault(
        "F08b",
        "every packet comes twice",
        "as F08a",
        lambda: counted("duplicated", Receipt.DUPLICATE, "link.duplicate=1"),
    ),
    Fault(
        "F09a",
        "one bit of every twentieth packet is flipped",
        "as F08a",
        lambda: counted("corrupted", Receipt.CORRUPTED, "link.corrupt=0.05"),
    ),
    Fault(
        "F22a",
        "the delay steps from 10 to 200 ms and back, every 2 s",
        "as F05d",
        lambda: carries(
            *("link.delay_s=0.01", "link.schedule=2 delay_s=0.2; 4 repeat"),
            "link.keep_order=false",
        ),
    ),
    Fault(
        "F22b",
        "the delay ramps between 20 and 200 ms, 0.9 s a second",
        "as F05d",
        lambda: carries(
            "link.delay_s=0.02",
            "link.keep_order=false",
            "link.schedule=0 delay_s=0.02..0.2; 0.2 delay_s=0.2..0.02; 0.4 repeat",
        ),
    ),
    Fault(
        "F22c",
        "jitter of 12 ms about 16 ms, Pareto distributed",
        "as F05d",
        lambda: carries(
            *CALM, "link.jitter=pareto", "link.jitter_s=0.012", "link.keep_order=false"
        ),
    ),
    Fault(
        "F22d",
        "20 % loss in bursts of 3, one of ten packets twice",
        "as F05d",
        lambda: carries(*CALM, "link.ge_p=0.0833", "link.ge_r=0.333", "link.duplicate=0.1"),
    ),
    Fault(
        "F23a",
        "125 packets a second become 12 for 3 s",
        "as F05d",
        lambda: carries(*CALM, "changes=5 master.rate_drop=80; 8 master.rate_drop=8", ends=True),
    ),
    Fault(
        "F23b",
        "nine of ten packets are lost for 3 s",
        "as F05d",
        lambda: carries(*CALM, "link.schedule=5 loss=0.9; 8 base", ends=True),
    ),
    Fault(
        "F24",
        "the server runs at 1 Hz for 5 s",
        "as F05d",
        lambda: carries(*CALM, "changes=4 server.period_s=1; 9 server.period_s=0.008", ends=True),
    ),
)
