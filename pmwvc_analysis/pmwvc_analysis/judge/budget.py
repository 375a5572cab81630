# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session: every joule from the hands to where it went, and what is left.

    hands = devices + safety + channels + server + residual

at every step of the server. A part whose sum ever is below zero has given out energy that it never
got: it was *active*. Parts and what they rest on: :mod:`.budget_device`,
:mod:`.budget_channel`, :mod:`.budget_server`.

The residual is what the parts, each computed for itself, do not explain. In a session of which
nothing is missing it is rounding, ``TOLERANCE`` of the energy moved; ticks that were not recorded
(live), and Coulomb friction where the motion turns, show: ``TOLERANCE_NOTED``. Where position or
velocity are measured rather than exact, what the sensors make up cannot be told from the sample
and hold, which is then what the other parts of the device leave over.
"""

from dataclasses import dataclass, field

import numpy as np

from pmwvc_analysis.judge.budget_channel import channel_account, master_account
from pmwvc_analysis.judge.budget_clock import Clock
from pmwvc_analysis.judge.budget_device import device_account, measured
from pmwvc_analysis.judge.budget_server import server_account
from pmwvc_analysis.judge.energy import TOLERANCE_J, TOLERANCE_RELATIVE, running
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.scenario import Scenario
from pmwvc_core.simulation.traces import ServerTraces, SessionTraces, UserTraces

TOLERANCE = 1e-9  # of the energy moved
TOLERANCE_NOTED = 2e-2  # where ``notes`` say why
SMALLEST_J = 1e-12
SERVER = "server"
USER_PARTS = (
    "device_kinetic",
    "device_damping",
    "sample_hold",
    "safety",
    "filter",
    "rate_drop",
    "link_up",
    "link_down",
    "hold",
)
JOINT_PART = "filter_and_rate_drop"
DIRECT_PARTS = ("device_kinetic", "device_damping", "sample_hold", "safety", "link")
SERVER_PARTS = (
    "late_decoding",
    "integration",
    "contact_damping",
    "contact_stored",
    "object_kinetic",
    "object_damping",
)


@dataclass(frozen=True)
class Active:
    """A part that gave out energy it never got."""

    owner: str
    part: str
    given_j: float  # at the worst
    since_s: float  # first seen
    time_s: float  # of the worst


@dataclass(frozen=True)
class Budget:
    """Running energies at ``time_s``; by owner (a user, or ``server``), then by part [J]."""

    time_s: Array
    hands: dict[str, Array]
    parts: dict[str, dict[str, Array]]
    residuals: dict[str, Array]
    notes: list[str] = field(default_factory=list)  # what keeps it from closing to rounding

    @property
    def residual_j(self) -> Array:
        """What the parts do not explain."""
        return np.asarray(sum(self.residuals.values()), dtype=float)

    @property
    def moved_j(self) -> float:
        """Energy that went through the hands, either way, or was held somewhere: the scale."""
        hands = sum(float(np.abs(np.diff(sums)).sum()) for sums in self.hands.values())
        held = (float(np.abs(s).max()) for each in self.parts.values() for s in each.values())
        return max(hands, *held, SMALLEST_J)

    @property
    def tolerance_j(self) -> float:
        """How large a residual may be."""
        return SMALLEST_J + (TOLERANCE_NOTED if self.notes else TOLERANCE) * self.moved_j

    @property
    def closes(self) -> bool:
        """Tell whether the residual was never larger than that."""
        return bool(np.abs(self.residual_j).max(initial=0.0) <= self.tolerance_j)

    @property
    def active(self) -> list[Active]:
        """Return the active parts, the one that gave out most first."""
        limit = TOLERANCE_J + TOLERANCE_RELATIVE * self.moved_j
        found = []
        for owner, parts in self.parts.items():
            for part, sums in _judged(parts).items():
                lowest = int(np.argmin(sums))
                if sums[lowest] < -limit:
                    first = int(np.argmax(sums < -limit))
                    found.append(
                        Active(
                            owner,
                            part,
                            -float(sums[lowest]),
                            float(self.time_s[first]),
                            float(self.time_s[lowest]),
                        )
                    )
        return sorted(found, key=lambda entry: -entry.given_j)


def _judged(parts: dict[str, Array]) -> dict[str, Array]:
    """Return the parts by which activity is told: the filter is there to pay for the rate drop."""
    found = dict(parts)
    if "filter" in found:
        found[JOINT_PART] = found.pop("filter") + found.pop("rate_drop")
    return found


def budget(traces: SessionTraces, scenario: Scenario | None) -> Budget | None:
    """Return the budget of a session; None without scenario, server or the master's own sums, and
    where motion is not finite.
    """
    server = traces.server
    if server is None or scenario is None or not len(server.time_s):
        return None
    known = {user.name: user for user in scenario.users}
    users = [u for u in traces.users if u.name in known and u.name in server.users]
    if not users or any(len(u.time_s) < 2 or "u_tx" not in u.energy for u in users):
        return None
    if not all(np.isfinite(u.x_m).all() and np.isfinite(u.xd_m).all() for u in users):
        return None
    clock = Clock(_times(traces, users))
    waves = scenario.controller != "direct"
    inside = server_account(clock, server, scenario)
    hands, parts, residuals = {}, {}, {}
    shared = inside["into_server"]
    for user in users:
        own = known[user.name]
        device = device_account(clock, user, own.device)
        port = master_account(clock, user, own, waves=waves)
        found = {**device, **port}
        if waves:
            live = traces.source == "live"
            found |= channel_account(clock, user, own, server, live=live)
        else:
            found["link"] = port["into_channel"] - _into(clock, server, user.name)
        hands[user.name] = device["hand"]
        parts[user.name] = {name: found[name] for name in (USER_PARTS if waves else DIRECT_PARTS)}
        residuals[user.name] = device["residual"] + port["residual"]
        shared = shared - _into(clock, server, user.name)
    parts[SERVER] = {name: inside[name] for name in SERVER_PARTS}
    residuals[SERVER] = inside["residual"] - shared  # of users whose own trace is not there
    return Budget(clock.time_s, hands, parts, residuals, _notes(traces, users, scenario))


def _into(clock: Clock, server: ServerTraces, name: str) -> Array:
    """Return what went into the server at one user's port [J]."""
    place = server.users.index(name)
    sums = running(server.energy_u_s[place]) - running(server.energy_v_s[place])
    return sums[: len(clock.time_s)]


def _times(traces: SessionTraces, users: list[UserTraces]) -> Array:
    """Return the times of the server's steps, up to the last one every user's ticks reach."""
    assert traces.server is not None
    times = traces.server.time_s
    lateness = traces.metadata.get("server_lateness_s")
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    end = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    reached: Array = times[times <= end + 1e-9]
    return reached if len(reached) else times[:1]


def _notes(traces: SessionTraces, users: list[UserTraces], scenario: Scenario) -> list[str]:
    """Return in words what keeps a budget from closing to rounding."""
    known = {user.name: user for user in scenario.users}
    found = []
    for user in users:
        device = known[user.name].device
        if not np.isfinite(user.f_h).all():
            found.append(
                f"{user.name}: the hand's force was not measured; it is taken to have given what "
                "the device shows"
            )
        missing = int(np.sum(np.diff(user.tick) - 1))
        if missing:
            found.append(f"{user.name}: {missing} ticks were not recorded")
        if measured(device):
            found.append(
                f"{user.name}: position or velocity is measured, not exact; what the sensors make "
                "up counts as sample and hold"
            )
        if device.friction > 0.0:
            found.append(f"{user.name}: the heat of friction is exact but where motion turns")
    assert traces.server is not None
    steps = int(np.sum(np.diff(traces.server.step) - 1))
    if steps:
        found.append(f"server: {steps} steps were not recorded")
    return found
