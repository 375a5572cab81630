# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy budget computed offline from the traces alone, without the accounts of the blocks.

Every formula of energy stands here for itself: differences of summed waves, the device's heat by
quadrature, the object's from its held forces. The product's budget sums what each block states
beside its law; :mod:`test_accounts` compares the two.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.budget.hand_work import hand_work
from pmwvc_analysis.traces.stretches import stretches
from pmwvc_analysis.traces.true_motion import TrueMotion, complete, measured, true_motion
from pmwvc_core.controllers import has_waves
from pmwvc_core.motion import motion
from pmwvc_core.numeric import Array, root
from pmwvc_core.params import DeviceParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

SERVER = "server"
KEPT = ("velocity_filter", "local_stored", "local_dissipated", "tdpa_dissipated")
SPENT = ("position_spent",)


class Offline(NamedTuple):
    """Running energies [J] by owner and part."""

    time_s: Array
    hands: dict[str, Array]
    parts: dict[str, "Sums"]
    residuals: dict[str, Array]
    frames: dict[str, "AtFrames"]


def offline(traces: SessionTraces, scenario: Scenario) -> Offline:
    """Return where the energy of the hands went."""
    server = traces.server
    assert server is not None
    known = {user.name: user for user in scenario.users}
    users = [u for u in traces.users if u.name in known and u.name in server.users]
    clock = _clock(traces, users)
    inside = server_account(clock, server, scenario)
    shared = inside.pop("into_server")
    waves = has_waves(scenario.controller)
    hands, parts, residuals, frames = {}, {}, {}, {}
    for user in users:
        own = known[user.name]
        device, _ = device_account(clock, user, own.device)
        hands[user.name] = device.pop("hand")
        residuals[user.name] = device.pop("residual")
        port = _port(clock, user, own, traces, waves=waves)
        residuals[user.name] = residuals[user.name] + port.pop("residual")
        device["sample_hold"] = device.pop("rendered") - port.pop("taken")
        parts[user.name] = {**device, **port}
        if waves and booked(user.accounts):
            frames[user.name] = at_frames(user, own)
        shared = shared - _into(clock, server, user.name)
    residuals[SERVER] = inside.pop("residual") - shared  # of users whose own trace is not there
    return Offline(clock.time_s, hands, {**parts, SERVER: inside}, residuals, frames)


def booked(accounts: dict[str, Array]) -> "Sums":
    """Return the accounts that are parts of a budget, as energy taken in."""
    kept = {name: accounts[name] for name in accounts if name in KEPT}
    return kept | {name: -accounts[name] for name in accounts if name in SPENT}


def half_square(wave: Array) -> Array:
    """Return the power of a wave, |w|^2 / 2 [W], per row."""
    power: Array = np.sum(wave * wave, axis=-1) / 2.0
    return power


def running(sums: Array) -> Array:
    """Return sums that only grow, going on where a user that left and came back began at zero."""
    result = sums.copy()
    for row in np.flatnonzero(np.diff(sums) < 0.0) + 1:
        result[row:] += result[row - 1] - (result[row] - sums[row])
    return result


def anchored(user: UserTraces, per_tick: Array, at_block_ends: Array | None) -> Array:
    """Return the running sum after each tick [J].

    The sums that the master itself kept, at the ends of its blocks, hold; in between the ticks'
    own values are added. So a block that was not recorded leaves no hole in the energy.
    """
    sums: Array = np.cumsum(per_tick)
    if at_block_ends is None or not len(at_block_ends):
        return sums
    last = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s) - 1
    blocks = np.clip(np.searchsorted(last, np.arange(len(sums))), 0, len(last) - 1)
    ends = np.clip(last, 0, len(sums) - 1)
    return sums + (at_block_ends - sums[ends])[blocks]


# Gauss-Legendre: exact for the square of a velocity that is a polynomial up to the third degree.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
Sums = dict[str, Array]  # running sums [J] at the instants, by part


class AtFrames(NamedTuple):
    """Running sums at times of their own: the ends of a master's frames."""

    time_s: Array
    sums: Sums


@dataclass(frozen=True)
class Clock:
    """The instants at which a budget is drawn up, and what had happened by then."""

    time_s: Array  # (instant,)
    steps: NDArray[np.intp]  # (instant,) rows of the server's steps

    def ticks_before(self, user: UserTraces) -> NDArray[np.intp]:
        """Return how many recorded ticks had run; never all, so that the next one's start is
        known.
        """
        ran = np.maximum.accumulate(user.time_s + user.lateness_s)
        count = np.searchsorted(ran, self.time_s - 0.001 * user.tick_s)
        return np.minimum(count, len(user.time_s) - 1)

    def at_ticks(self, user: UserTraces, per_tick: Array) -> Array:
        """Return the running sum of something per tick."""
        return np.concatenate([[0.0], np.cumsum(per_tick)])[self.ticks_before(user)]

    def of_ticks(self, user: UserTraces, sums: Array) -> Array:
        """Return what already is a running sum, after each tick."""
        return np.concatenate([[0.0], sums])[self.ticks_before(user)]

    def of_blocks(self, user: UserTraces, sums: Array, frame_s: float, *, after_s: float) -> Array:
        """Return a sum the master kept, which grows ``after_s`` into each of its frames."""
        ends = user.block_time_s
        starts = np.maximum(ends - frame_s, np.concatenate([[-np.inf], ends[:-1]]))
        first = np.searchsorted(user.time_s, starts + after_s - 0.5 * user.tick_s)
        ran = np.maximum.accumulate(user.time_s + user.lateness_s)
        count = np.searchsorted(
            ran[np.minimum(first, len(ran) - 1)], self.time_s + 0.001 * user.tick_s
        )
        return np.concatenate([[0.0], sums])[count]


def speeds(mass: float, damping: float, period_s: float, xd: Array, force: Array) -> list[Array]:
    """Return the velocities at the nodes of a period that starts with ``xd`` under a force."""
    return [
        np.asarray(motion(mass, damping, 0.5 * (1.0 + node) * period_s).advance(0.0, xd, force)[1])
        for node in NODES
    ]


def sum_of(sums: list[Array]) -> Array:
    """Return the sum of several energies over time."""
    return np.asarray(np.sum(sums, axis=0), dtype=float)


def _port(
    clock: Clock, user: UserTraces, known: User, traces: SessionTraces, *, waves: bool
) -> Sums:
    """Return the parts between a device and the server's port, and ``residual``."""
    assert traces.server is not None
    port = master_account(clock, user, known, waves=waves)
    into_channel = port.pop("into_channel")
    if not waves:
        own = evenly(clock, user, booked(user.accounts))
        link = into_channel - _into(clock, traces.server, user.name)
        return {**port, **own, "link": link - sum_of([*own.values(), 0.0 * link])}
    found = channel_account(clock, user, known, traces.server, live=traces.source == "live")
    if booked(user.accounts):
        own = between(clock, user, known)
        rest = found.pop("filter") + found.pop("hold") - sum_of(list(own.values()))
        found = {**own, "filter_and_hold": rest, **found}
    return {**port, **found}


def _into(clock: Clock, server: ServerTraces, name: str) -> Array:
    """Return what went into the server at one user's port [J]."""
    place = server.users.index(name)
    sums = running(server.energy_u_s[place]) - running(server.energy_v_s[place])
    return np.asarray(sums[clock.steps], dtype=float)


def _clock(traces: SessionTraces, users: list[UserTraces]) -> Clock:
    """Return the times of the server's steps of which every user's record tells, up to the last
    one that every user's ticks reach.
    """
    assert traces.server is not None
    times = traces.server.time_s
    lateness = traces.metadata.get("server_lateness_s")
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    end = min(float(user.time_s[-1] + user.lateness_s[-1]) for user in users)
    known = times <= end + 1e-9
    for user in users:
        stays = stretches(user, traces.server, traces)
        known &= stays.known(times) & (times <= stays.lives[0].end_s)
    rows = np.flatnonzero(known) if known.any() else np.zeros(1, dtype=np.intp)
    return Clock(times[rows], rows)


REST = ("filter_and_hold", "rate_drop")


def at_frames(user: UserTraces, known: User) -> AtFrames:
    """Return the parts, ``filter_and_hold`` and ``rate_drop`` at the ends of frames.

    The packet that a frame's filter output becomes is the next one sent, so the last frame is left
    out.
    """
    found = _at_frames(user, known)
    return AtFrames(user.block_time_s[:-1], {name: sums[:-1] for name, sums in found.items()})


def _at_frames(user: UserTraces, known: User) -> Sums:
    """Return all parts; see :func:`at_frames`.

    What a bank's low branch took in is what the anti-aliasing filter got, what it gave out came
    from the hold: so there filter and hold are known, and the bank is what is left.
    """
    parts, energy, accounts = booked(user.accounts), user.energy, user.accounts
    sent = np.concatenate([energy["u_tx"][1:], energy["u_tx"][-1:]])
    if known.master.filter.kind == "integrate_and_dump":
        filtered = sent
    else:
        count = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
        per_tick = half_square(user.u_m_lp) * user.tick_s
        filtered = np.concatenate([[0.0], np.cumsum(per_tick)])[count]
    left = energy["u_m"] - energy["v_m"] - filtered + energy["v_rx"]
    left = left - sum_of([0.0 * left, *parts.values()])
    found = {**parts, "filter_and_hold": left, "rate_drop": filtered - sent}
    if "bank_low_in" in accounts:
        net = accounts["bank_low_in"] - accounts["bank_low_out"]
        found["filter_and_hold"] = net - filtered + energy["v_rx"]
        if "position_spent" in parts:
            found["filter_and_hold"] = found["filter_and_hold"] - parts["position_spent"]
        found["bank"] = left - found["filter_and_hold"]
    return found


def between(clock: Clock, user: UserTraces, known: User) -> Sums:
    """Return the parts, without filter, hold and rate drop, at the instants of a budget."""
    found = _at_frames(user, known)
    return evenly(clock, user, {name: found[name] for name in found if name not in REST})


def evenly(clock: Clock, user: UserTraces, sums: Sums) -> Sums:
    """Return sums that are known at the ends of frames at the instants of a budget."""
    ends = np.concatenate([[0.0], user.block_time_s])
    return {
        name: np.interp(clock.time_s, ends, np.concatenate([[0.0], each]))
        for name, each in sums.items()
    }


LIVE_TAKE_S = 0.004  # a live master takes the answer that much into its frame
UNLIMITED_N = 1e-9  # forces closer than this are the same
UNLIMITED_ROOT_W = 1e-9


def master_account(clock: Clock, user: UserTraces, known: User, *, waves: bool) -> Sums:
    """Return ``taken`` (F xd T_c), ``safety``, ``into_channel`` (both ways), ``residual`` of the
    master's port [J], and ``force_velocity_filter`` where there is one.

    In a gap of the record the master's own sums hold, and what was taken there is what they say.
    """
    power = np.sum(user.f_applied * user.xd_m, axis=-1)
    taken = clock.at_ticks(user, power * user.tick_s)
    if not waves:
        said = user.energy["u_m"] - user.energy["v_m"]
        into = clock.of_ticks(user, anchored(user, power * user.tick_s, said))
        taken = taken if complete(user) else into
        return {
            "taken": taken,
            "safety": 0.0 * taken,
            "into_channel": into,
            "residual": taken - into,
        }
    net = half_square(user.u_m) - half_square(user.v_m)
    u_m, v_m = (_kept(clock, user, name) for name in ("u_m", "v_m"))
    if not complete(user):
        taken = taken + (u_m - v_m) - clock.at_ticks(user, net * user.tick_s)
    natural = root(2.0 * known.impedance) * user.xd_m - user.v_m
    limited = (np.abs(user.f_applied - user.f_m) > UNLIMITED_N).any(axis=-1)
    limited |= (np.abs(user.u_m - natural) > UNLIMITED_ROOT_W).any(axis=-1)
    found: Sums = {}
    if known.master.velocity_filter.kind == "equivalent":
        unfiltered = known.impedance * user.xd_m - root(2.0 * known.impedance) * user.v_m
        kept = np.sum((user.f_m - unfiltered) * user.xd_m, axis=-1)
        net = net + kept
        found["force_velocity_filter"] = clock.at_ticks(user, kept * user.tick_s)
    found["safety"] = clock.at_ticks(user, np.where(limited, power - net, 0.0) * user.tick_s)
    left = taken - (u_m - v_m) - sum_of(list(found.values()))
    return {"taken": taken, **found, "into_channel": u_m - v_m, "residual": left}


def _kept(clock: Clock, user: UserTraces, wave: str) -> Array:
    """Return the energy of a wave of the master's ticks."""
    per_tick = half_square(getattr(user, wave)) * user.tick_s
    return clock.of_ticks(user, anchored(user, per_tick, user.energy.get(wave)))


def channel_account(
    clock: Clock, user: UserTraces, known: User, server: ServerTraces, *, live: bool
) -> Sums:
    """Return ``filter``, ``rate_drop``, ``link_up``, ``link_down``, ``hold`` [J].

    Integrate-and-dump filters and drops in one; there the rate drop has nothing of its own. A link
    includes what is under way, and what becomes of packets at a server of another period.
    """
    place = server.users.index(user.name)
    frame_s, take_s = known.master.frame_s, LIVE_TAKE_S if live else 0.0
    u_m, v_m = _kept(clock, user, "u_m"), _kept(clock, user, "v_m")
    u_tx = clock.of_blocks(user, user.energy["u_tx"], frame_s, after_s=0.0)
    v_rx = clock.of_blocks(user, user.energy["v_rx"], frame_s, after_s=take_s)
    u_s, v_s = running(server.energy_u_s[place]), running(server.energy_v_s[place])
    if known.master.filter.kind == "integrate_and_dump":
        filtered = u_tx
    else:
        filtered = clock.at_ticks(user, half_square(user.u_m_lp) * user.tick_s)
    return {
        "filter": u_m - filtered,
        "rate_drop": filtered - u_tx,
        "link_up": u_tx - u_s[clock.steps],
        "link_down": v_s[clock.steps] - v_rx,
        "hold": v_rx - v_m,
    }


def device_account(clock: Clock, user: UserTraces, params: DeviceParams) -> tuple[Sums, set[str]]:
    """Return ``hand``, ``device_kinetic``, ``device_damping``, ``rendered``, ``residual`` [J], and
    which of them are remainders.

    A hand whose force nobody measured is taken to have given what the device shows.
    """
    known = bool(np.isfinite(user.f_h).all())
    motion = true_motion(user, params) if measured(params) else _recorded(user)
    if motion is None:
        return _unresolved(clock, user, params, known=known)
    moved = np.diff(motion.x, axis=0)
    f = user.f_applied
    rendered = _summed(clock, user, np.sum(f * moved, axis=-1), "device")
    kinetic = 0.5 * params.mass * np.sum(motion.xd[:-1] ** 2, axis=-1)
    push = (user.f_h if known else 0.0) - f
    found = {
        "device_kinetic": kinetic[clock.ticks_before(user)] - kinetic[0],
        "device_damping": clock.at_ticks(user, _device_heat(params, user, motion, push)),
    }
    spent = found["device_kinetic"] + found["device_damping"] + rendered
    hand = _summed(clock, user, np.sum(user.f_h * moved, axis=-1), "hand") if known else spent
    sums = {"hand": hand, **found, "rendered": rendered, "residual": hand - spent}
    return sums, set() if known else {"hand"}


def _recorded(user: UserTraces) -> TrueMotion:
    return TrueMotion(
        np.concatenate([user.x_m, user.x_m[-1:]]), np.concatenate([user.xd_m, user.xd_m[-1:]])
    )


def _summed(clock: Clock, user: UserTraces, per_tick: Array, said: str) -> Array:
    """Return a running sum of ticks; over gaps that of the master holds."""
    if complete(user) or said not in user.energy:
        return clock.at_ticks(user, per_tick)
    return clock.of_ticks(user, anchored(user, per_tick, user.energy[said]))


def _unresolved(
    clock: Clock, user: UserTraces, params: DeviceParams, *, known: bool
) -> tuple[Sums, set[str]]:
    """Return what is known of a device whose true motion is not."""
    rendered = hand_work(user, params).at(user, clock.time_s).sums
    kinetic = 0.5 * params.mass * np.sum(user.xd_m**2, axis=-1)
    in_motion = kinetic[clock.ticks_before(user)] - kinetic[0]
    hand = rendered + in_motion
    if known and "hand" in user.energy:
        ends = np.searchsorted(user.block_time_s, clock.time_s + 0.001 * user.tick_s)
        hand = np.concatenate([[0.0], user.energy["hand"]])[ends]
    sums = {
        "hand": hand,
        "device_kinetic": in_motion,
        "device_damping": hand - rendered - in_motion,
        "rendered": rendered,
        "residual": 0.0 * hand,
    }
    return sums, {"device_damping"} if known else {"hand"}


def _device_heat(params: DeviceParams, user: UserTraces, motion: TrueMotion, push: Array) -> Array:
    """Return the heat of each tick [J]: damper, friction, stops."""
    xd, after, tick_s = motion.xd[:-1], motion.xd[1:], user.tick_s
    moved = np.diff(motion.x, axis=0)
    if np.isfinite(user.f_h).all() and params.friction == 0.0:
        nodes = speeds(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        nodes = [0.5 * ((1.0 - node) * xd + (1.0 + node) * after) for node in NODES]
    square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, nodes, strict=True))
    heat = params.damping * tick_s * square
    heat = heat + params.friction * np.linalg.norm(moved, axis=-1)
    stopped = (np.abs(motion.x[1:]) >= params.workspace_m).any(axis=-1)
    lost = np.sum(push * moved, axis=-1) - 0.5 * params.mass * np.sum(after**2 - xd**2, axis=-1)
    return np.asarray(np.where(stopped, lost, heat), dtype=float)


MOVED_BY_NEW_FORCE = ("implicit", "one_frame_late")  # the others: by the force of the step before


def server_account(clock: Clock, server: ServerTraces, scenario: Scenario) -> Sums:
    """Return what the server took in and where it is [J].

    ``into_server`` at all wave ports; ``late_decoding``, ``contact_damping``, ``contact_stored``,
    ``object_kinetic``, ``object_damping``; ``integration``, which the steps of a sampled coupling
    leave over; ``residual``. The implicit coupling leaves nothing over; there it is the residual.
    An unknown environment has parts of its own.
    """
    into = sum(
        (
            running(u) - running(v)
            for u, v in zip(server.energy_u_s, server.energy_v_s, strict=True)
        ),
        start=np.zeros(len(server.time_s)),
    )
    power = sum(
        np.nan_to_num(np.sum(f * xd, axis=-1))
        for f, xd in zip(server.f_s, server.xd_s, strict=True)
    )
    work = np.cumsum(power) * server.period_s
    waves = has_waves(scenario.controller)
    if waves and scenario.server.coupling == "unknown":
        found = _of_unknown(server, into, work)
    else:
        found = _of_known(server, scenario, into, work, waves=waves)
    return {name: sums[clock.steps] for name, sums in {"into_server": into, **found}.items()}


def _of_known(
    server: ServerTraces, scenario: Scenario, into: Array, work: Array, *, waves: bool
) -> Sums:
    coupling = scenario.server.coupling
    decoding = into - work if waves and coupling == "one_step_delay" else np.zeros_like(into)
    damping, missing = _object_heat(server, scenario)
    contact = server.dissipated - damping - missing
    left = into - decoding - server.kinetic - server.potential - server.dissipated
    exact = waves and coupling == "implicit"
    return {
        "late_decoding": decoding,
        "integration": 0.0 * left if exact else left,
        "contact_damping": contact,
        "contact_stored": server.potential,
        "object_kinetic": server.kinetic,
        "object_damping": damping,
        "residual": left + missing if exact else missing,
    }


def _of_unknown(server: ServerTraces, into: Array, work: Array) -> Sums:
    """Return the parts of a port that knows nothing of its environment: what it booked, and the
    work of the forces as recorded. Contained users' forces are those of a matched damper.
    """
    accounts = server.accounts
    return {
        "late_decoding": accounts["late_decoding"],
        "withheld": accounts["withheld"],
        "contained": accounts["contained"],
        "environment_stored": server.potential,
        "environment_heat": work - accounts["contained"] - server.potential,
        "residual": into - work - accounts["late_decoding"] - accounts["withheld"],
    }


def _object_heat(server: ServerTraces, scenario: Scenario) -> tuple[Array, Array]:
    """Return the heat of the object's damper [J], and what the forces' work on it leaves over."""
    params = scenario.server
    if params.environment != "cube":
        return np.zeros(len(server.time_s)), np.zeros(len(server.time_s))
    force = sum((np.nan_to_num(f) for f in server.f_s), start=np.zeros_like(server.x_o))
    moved = np.diff(server.x_o, axis=0, prepend=server.x_o[:1])
    before = np.concatenate([0.0 * server.xd_o[:1], server.xd_o[:-1]])
    coupling = params.coupling if has_waves(scenario.controller) else None
    if coupling not in MOVED_BY_NEW_FORCE:
        force = np.concatenate([0.0 * force[:1], force[:-1]])
    if coupling == "implicit":
        heat = params.object_damping * np.sum(moved**2, axis=-1) / server.period_s
    else:
        nodes = speeds(params.object_mass, params.object_damping, server.period_s, before, force)
        square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, nodes, strict=True))
        heat = params.object_damping * server.period_s * square
    kinetic = np.diff(server.kinetic, prepend=0.0)
    missing = np.sum(force * moved, axis=-1) - kinetic - heat
    return np.cumsum(heat), np.cumsum(missing)
