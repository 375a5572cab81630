# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget computed offline from the traces alone, without the accounts of the blocks.

Every formula of energy stands here for itself: differences of summed waves, the device's heat by
quadrature, the object's from its held forces. The product's budget sums what each block states
beside its law; :mod:`test_accounts` compares the two.
"""

from typing import NamedTuple

from oracle.offline_budget.device import device_account
from oracle.offline_budget.frames import AtFrames, at_frames, booked
from oracle.offline_budget.port import into_server, port_account
from oracle.offline_budget.server import server_account
from oracle.offline_budget.sums import Sums, clock_of

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

SERVER = "server"


class Offline(NamedTuple):
    """Running energies [J] by owner and part."""

    time_s: Array
    hands: dict[str, Array]
    parts: dict[str, Sums]
    residuals: dict[str, Array]
    frames: dict[str, AtFrames]


def offline(traces: SessionTraces, scenario: Scenario) -> Offline:
    """Return where the energy of the hands went."""
    server = traces.server
    assert server is not None
    known = {user.name: user for user in scenario.users}
    users = [u for u in traces.users if u.name in known and u.name in server.users]
    clock = clock_of(traces, users)
    inside = server_account(clock, server, scenario)
    shared = inside.pop("into_server")
    waves = has_waves(scenario.controller)
    hands, parts, residuals, frames = {}, {}, {}, {}
    for user in users:
        own = known[user.name]
        device = device_account(clock, user, own.device)
        hands[user.name] = device.pop("hand")
        residuals[user.name] = device.pop("residual")
        port = port_account(clock, user, own, traces, waves=waves)
        residuals[user.name] = residuals[user.name] + port.pop("residual")
        device["sample_hold"] = device.pop("rendered") - port.pop("taken")
        parts[user.name] = {**device, **port}
        if waves and booked(user.accounts):
            frames[user.name] = at_frames(user, own)
        shared = shared - into_server(clock, server, user.name)
    residuals[SERVER] = inside.pop("residual") - shared  # of users whose own trace is not there
    return Offline(clock.time_s, hands, {**parts, SERVER: inside}, residuals, frames)
