# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the energy of a session goes, part by part: running sums from the traces [J].

Each function follows the energy through one stretch of the loop and returns, per part, how much it
has taken in and not given on, at the times asked for. What each sum rests on:

======================  ==========================================================================
hand                    sum f_h . (x(k+1) - x(k)): a force held over a tick works on what it moves
device in motion        m |xd|^2 / 2
device damping          b_hd times the integral of |xd|^2, exact between ticks; Coulomb friction;
                        what is lost at a mechanical stop
sample and hold         F . (x(k+1) - x(k)) less F . xd T_c: the controller books the velocity at
                        the tick, the device moves on with the force held
safety                  F xd T_c less (|u_m|^2 - |v_m|^2) T_c/2, in ticks that were limited
filter, rate drop,      differences of the energies of u_m, u_m after the filter, u_tx, u_s and of
link, hold              v_s, v_rx, v_m
late decoding           (|u_s|^2 - |v_s|^2)/2 less F_s . xd_s: the force of the step before
object damping          b_o times the integral of |xd_o|^2
contact damping         what the server turned to heat, less what the object lost: the forces'
                        work on it less its gain in motion
======================  ==========================================================================
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.judge.energy import anchored, half_square, running
from pmwvc_core.numeric import Array
from pmwvc_core.params import DeviceParams
from pmwvc_core.plant.motion import motion
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.traces import ServerTraces, UserTraces

Sums = dict[str, Array]
LIVE_TAKE_S = 0.004  # a live master takes the answer that much into its frame
UNLIMITED_N = 1e-9  # forces closer than this are the same
UNLIMITED_ROOT_W = 1e-9
MOVED_BY_NEW_FORCE = ("implicit", "one_frame_late")  # the others: by the force of the step before
# Gauss-Legendre: exact for the square of a velocity that is a polynomial up to the third degree.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Clock:
    """The instants at which a budget is drawn up, and what had happened by then."""

    time_s: Array  # (step,)

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


def device_account(clock: Clock, user: UserTraces, params: DeviceParams) -> Sums:
    """Return ``hand``, ``device_kinetic``, ``device_damping``, ``sample_hold``, ``residual`` [J].

    A hand whose force nobody measured is taken to have given what the device shows; then there is
    no residual.
    """
    x, xd, f = user.x_m, user.xd_m, user.f_applied
    moved = np.diff(x, axis=0, append=x[-1:])
    rendered = np.sum(f * moved, axis=-1)
    kinetic = 0.5 * params.mass * np.sum(xd**2, axis=-1)
    known = bool(np.isfinite(user.f_h).all())
    push = (user.f_h if known else 0.0) - f
    damping = _device_heat(params, user, moved, push)
    found = {
        "device_kinetic": kinetic[clock.ticks_before(user)] - kinetic[0],
        "device_damping": clock.at_ticks(user, damping),
        "sample_hold": clock.at_ticks(user, rendered - np.sum(f * xd, axis=-1) * user.tick_s),
    }
    spent = found["device_kinetic"] + found["device_damping"] + clock.at_ticks(user, rendered)
    hand = clock.at_ticks(user, np.sum(user.f_h * moved, axis=-1)) if known else spent
    if measured(params):
        found["sample_hold"] = found["sample_hold"] + (hand - spent)
        spent = hand
    return {"hand": hand, **found, "residual": hand - spent}


def measured(params: DeviceParams) -> bool:
    """Tell whether the sensors show something else than the device does."""
    return bool(params.encoder_step_m > 0.0) or params.velocity != "exact"


def _device_heat(params: DeviceParams, user: UserTraces, moved: Array, push: Array) -> Array:
    """Return the heat of each tick [J]: damper, friction, stops."""
    xd, tick_s = user.xd_m, user.tick_s
    after = np.concatenate([xd[1:], xd[-1:]])
    if np.isfinite(user.f_h).all() and params.friction == 0.0:
        speeds = _speeds(params.mass, params.damping, tick_s, xd, push)
    else:  # within a tick the velocity is as good as a straight line
        speeds = [0.5 * ((1.0 - node) * xd + (1.0 + node) * after) for node in NODES]
    square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, speeds, strict=True))
    heat = params.damping * tick_s * square
    heat = heat + params.friction * np.sum(np.abs(moved), axis=-1)
    end = np.concatenate([user.x_m[1:], user.x_m[-1:]])
    stopped = (np.abs(end) >= params.workspace_m).any(axis=-1)
    lost = np.sum(push * moved, axis=-1) - 0.5 * params.mass * np.sum(after**2 - xd**2, axis=-1)
    return np.asarray(np.where(stopped, lost, heat), dtype=float)


def _speeds(mass: float, damping: float, period_s: float, xd: Array, force: Array) -> list[Array]:
    """Return the velocities at the nodes of a period that starts with ``xd`` under a force."""
    return [
        np.asarray(motion(mass, damping, 0.5 * (1.0 + node) * period_s).advance(0.0, xd, force)[1])
        for node in NODES
    ]


def master_account(clock: Clock, user: UserTraces, known: User, *, waves: bool) -> Sums:
    """Return ``safety``, ``into_channel`` (both ways), ``residual`` of the master's port [J]."""
    power = np.sum(user.f_applied * user.xd_m, axis=-1)
    taken = clock.of_ticks(user, anchored(user, power * user.tick_s, user.energy.get("device")))
    if not waves:
        return {"safety": 0.0 * taken, "into_channel": taken, "residual": 0.0 * taken}
    net = half_square(user.u_m) - half_square(user.v_m)
    b = float(known.master.impedance)
    natural = np.sqrt(2.0 * b) * user.xd_m - user.v_m
    limited = (np.abs(user.f_applied - user.f_m) > UNLIMITED_N).any(axis=-1)
    limited |= (np.abs(user.u_m - natural) > UNLIMITED_ROOT_W).any(axis=-1)
    safety = clock.at_ticks(user, np.where(limited, power - net, 0.0) * user.tick_s)
    u_m, v_m = (_kept(clock, user, name) for name in ("u_m", "v_m"))
    return {
        "safety": safety,
        "into_channel": u_m - v_m,
        "residual": taken - (u_m - v_m) - safety,
    }


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
    count = len(clock.time_s)
    if known.master.filter.kind == "integrate_and_dump":
        filtered = u_tx
    else:
        filtered = clock.at_ticks(user, half_square(user.u_m_lp) * user.tick_s)
    return {
        "filter": u_m - filtered,
        "rate_drop": filtered - u_tx,
        "link_up": u_tx - u_s[:count],
        "link_down": v_s[:count] - v_rx,
        "hold": v_rx - v_m,
    }


def server_account(clock: Clock, server: ServerTraces, scenario: Scenario) -> Sums:
    """Return what the server took in and where it is [J].

    ``into_server`` at all wave ports; ``late_decoding``, ``contact_damping``, ``contact_stored``,
    ``object_kinetic``, ``object_damping``; ``integration``, which the steps of a sampled coupling
    leave over; ``residual``. The implicit coupling leaves nothing over; there it is the residual.
    """
    count, period = len(clock.time_s), server.period_s
    into = sum(
        (
            running(u) - running(v)
            for u, v in zip(server.energy_u_s, server.energy_v_s, strict=True)
        ),
        start=np.zeros(len(server.time_s)),
    )
    work = sum(
        np.nan_to_num(np.sum(f * xd, axis=-1))
        for f, xd in zip(server.f_s, server.xd_s, strict=True)
    )
    coupling = scenario.server.coupling
    late = scenario.controller != "direct" and coupling == "one_step_delay"
    decoding = into - np.cumsum(work) * period if late else np.zeros_like(into)
    damping, missing = _object_heat(server, scenario)
    contact = server.dissipated - damping - missing
    left = into - decoding - server.kinetic - server.potential - server.dissipated
    exact = scenario.controller != "direct" and coupling == "implicit"
    found = {
        "into_server": into,
        "late_decoding": decoding,
        "integration": 0.0 * left if exact else left,
        "contact_damping": contact,
        "contact_stored": server.potential,
        "object_kinetic": server.kinetic,
        "object_damping": damping,
        "residual": left + missing if exact else missing,
    }
    return {name: sums[:count] for name, sums in found.items()}


def _object_heat(server: ServerTraces, scenario: Scenario) -> tuple[Array, Array]:
    """Return the heat of the object's damper [J], and what the forces' work on it leaves over."""
    params = scenario.server
    if params.environment != "cube":
        return np.zeros(len(server.time_s)), np.zeros(len(server.time_s))
    force = sum((np.nan_to_num(f) for f in server.f_s), start=np.zeros_like(server.x_o))
    moved = np.diff(server.x_o, axis=0, prepend=server.x_o[:1])
    before = np.concatenate([0.0 * server.xd_o[:1], server.xd_o[:-1]])
    direct = scenario.controller == "direct"
    if direct or params.coupling not in MOVED_BY_NEW_FORCE:
        force = np.concatenate([0.0 * force[:1], force[:-1]])
    if not direct and params.coupling == "implicit":
        heat = params.object_damping * np.sum(moved**2, axis=-1) / server.period_s
    else:
        speeds = _speeds(params.object_mass, params.object_damping, server.period_s, before, force)
        square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, speeds, strict=True))
        heat = params.object_damping * server.period_s * square
    kinetic = np.diff(server.kinetic, prepend=0.0)
    missing = np.sum(force * moved, axis=-1) - kinetic - heat
    return np.cumsum(heat), np.cumsum(missing)
