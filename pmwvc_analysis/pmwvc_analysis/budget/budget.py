# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget of a session: every joule from the hands to where it went, and what is left.

    hands = devices + safety + channels + server + residual

at every step of the server, with the blocks of each user that had ended by then. Each part is the
account of a block, stated beside the block's law and summed over the session: of a user's blocks
in :mod:`.blocks`, of the server here. The residual is what the parts do not explain: rounding.
The budget ends where something is missing in the record, where a master or the server was started
again, and where a parameter of the server changed.

Equations: docs/theory.md 13.6, 14.3.
"""

import numpy as np

from pmwvc_analysis.budget import blocks
from pmwvc_analysis.budget.energy import declared_j, server_sums
from pmwvc_analysis.budget.parts import notes_on, of_server
from pmwvc_analysis.budget.result import SERVER, Budget, Sums
from pmwvc_analysis.traces.block_sums import BlockSums
from pmwvc_analysis.traces.holes import Kind, Unjudged, ran_s, stretch
from pmwvc_analysis.traces.stages import stages, until
from pmwvc_analysis.traces.sums import running
from pmwvc_core.account import Account
from pmwvc_core.controllers.accounts import BRAKES, CONTACTS, DECODING, ENVIRONMENT, PORT
from pmwvc_core.numeric import Array, Value, dot, squared
from pmwvc_core.plant.device import damper_heat
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces


@np.errstate(over="ignore", invalid="ignore")  # a recording may hold any number
def budget(traces: SessionTraces, scenario: Scenario | None) -> Budget | None:
    """Return the budget of a session; None without scenario, server or the master's own sums, and
    where motion is not finite.
    """
    if scenario is None or (server := traces.server) is None or not len(server.time_s):
        return None
    scenario, ended = _ended(traces, server, scenario)
    known = {user.name: user for user in scenario.users}
    traces = until(traces, ended.start_s) if ended else traces
    if (server := traces.server) is None:
        return None
    users = [u for u in traces.users if u.name in known and u.name in server.users]
    if not users or any(len(u.time_s) < 2 for u in users):
        return None
    if not all(np.isfinite(u.x_m).all() and np.isfinite(u.xd_m).all() for u in users):
        return None
    times = ran_s(server, traces)
    end_s = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    start_s = max(stretch(user, server).start_s for user in users)
    # steps that every user's record contains
    rows = np.flatnonzero((times >= start_s) & (times <= end_s + 1e-9))
    if not len(rows):
        return None
    time_s = times[rows]
    taken, given, _ = server_sums(server)
    inside, unexplained = _server_parts(server, scenario, taken - given)
    of_users, unrecorded = {}, (taken - given)[rows]  # users other than these sent no trace
    for user in users:
        kept, index = BlockSums(user, traces.live), server.users.index(user.name)
        u_s, v_s = (running(e[index])[rows] for e in (server.energy_u_s, server.energy_v_s))
        unrecorded = unrecorded - (u_s - v_s)
        at = blocks.At(kept, kept.ended(time_s), kept.sent(time_s), u_s, v_s)
        of_users[user.name] = blocks.of_user(at, known[user.name], scenario)
    left_over = [(name, part) for name, own in of_users.items() for part in sorted(own.remainders)]
    residuals = {name: own.residual for name, own in of_users.items()}
    return Budget(
        time_s,
        {name: own.hand for name, own in of_users.items()},
        {name: own.parts for name, own in of_users.items()}
        | {SERVER: {part: sums[rows] for part, sums in inside.items()}},
        residuals | {SERVER: unexplained[rows] - unrecorded},
        notes_on(users, known, ended),
        {user.name: declared_j(scenario, known[user.name]) for user in users},
        [*left_over, *((SERVER, part) for part in sorted(of_server(scenario)))],
        server_is_whole=bool(server.step[0] <= 1),
    )


def _ended(
    traces: SessionTraces, server: ServerTraces, scenario: Scenario
) -> tuple[Scenario, Unjudged | None]:
    """Return the scenario at the start, and what ends its budget, if anything."""
    users = (each for each in traces.users if each.name in server.users)
    ends = (each for user in users for each in stretch(user, server).unjudged)
    unknown = [each for each in ends if each.start_s > 0.0]
    first, *later = stages(traces, scenario)
    for stage in later:
        if stage.start_s <= 0.0:
            first = stage
        elif stage.scenario.server != first.scenario.server:
            at_s = stage.start_s - 1e-9
            unknown.append(Unjudged(at_s, at_s, SERVER, Kind.CHANGE))
    return first.scenario, min(unknown, default=None)


def _server_parts(server: ServerTraces, scenario: Scenario, into: Array) -> tuple[Sums, Array]:
    """Return the parts of the server at all its steps, and what they do not explain.

    ``integration`` is what the steps of a sampled coupling leave over. The implicit coupling
    leaves nothing over; there it belongs to the residual. A black box has parts of its own.
    """
    ports = zip(server.f_s, server.xd_s, strict=True)
    power = sum(np.nan_to_num(np.sum(f * xd, axis=-1)) for f, xd in ports)
    work = np.cumsum(power * server.periods_s)
    own, braked = server.accounts, {}
    if BRAKES.name in own:
        braked, into = {BRAKES.name: own[BRAKES.name]}, into - own[BRAKES.name]
    if scenario.coupling.black_box:
        energies = {**own, "ports": into, "avatars": work, "reported": server.potential}
        left = blocks.passed((PORT, ENVIRONMENT), energies)
        return {
            **{part: own[part] for part in ("late_decoding", "withheld", "contained")},
            **braked,
            "environment_stored": server.potential,
            ENVIRONMENT.part: left[ENVIRONMENT.part],
        }, left[PORT.part]
    coupling, body = scenario.coupling, _object(server, scenario)
    energies = {
        "ports": into,
        "avatars": work if coupling.late else into,
        "object": np.asarray(body.taken),
        "springs": server.potential,
        "dampers": np.asarray(server.dissipated - body.dissipated - body.residual),
    }
    left = blocks.passed((DECODING, CONTACTS), energies)
    none, residual = np.zeros(len(into)), left[CONTACTS.part]
    return {
        **braked,
        DECODING.part: left[DECODING.part],
        CONTACTS.part: none if coupling.exact else residual,
        "contact_damping": energies["dampers"],
        "contact_stored": server.potential,
        "object_kinetic": np.asarray(body.stored),
        "object_damping": np.asarray(body.dissipated),
    }, np.asarray(body.residual + (residual if coupling.exact else none))


def _object(server: ServerTraces, scenario: Scenario) -> Account:
    """Return the account of the object since the start."""
    none = np.zeros(len(server.time_s))
    if not scenario.environment.movable:
        return Account(server.kinetic, none, server.kinetic, none)
    params, motion = scenario.server, scenario.coupling.object_motion
    force = sum((np.nan_to_num(f) for f in server.f_s), start=np.zeros_like(server.x_o))
    before = np.concatenate([0.0 * force[:1], force[:-1]])
    velocity = np.concatenate([0.0 * server.xd_o[:1], server.xd_o[:-1]])
    m, b, h = params.object_mass, params.object_damping, server.periods_s[:, np.newaxis]
    moved = np.diff(server.x_o, axis=0, prepend=server.x_o[:1])
    push = before if motion == "held_before" else force
    heat: Value = b / h * squared(moved)  # by the midpoint rule: at a mean velocity
    if motion != "midpoint":
        heat = damper_heat(m, b, h, velocity, push)
    taken = np.cumsum(dot(push, moved))
    return Account(taken, none, server.kinetic, np.cumsum(heat))
