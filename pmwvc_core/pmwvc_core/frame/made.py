# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of both ends made from parameters: what they start from, and what they go by."""

from typing import Any

import numpy as np

import pmwvc_core.law.port.strict_master  # noqa: F401  # joins the families
from pmwvc_core.controllers.library import has_waves, is_strict, is_zeroing
from pmwvc_core.frame.receivers import REPAID_M_S
from pmwvc_core.law.channel.arrivals import ArrivalsParams, start_of
from pmwvc_core.law.channel.frames import FrameParams, Frames
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.channel.packing import packing_params, resting_packing
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.port.filter_bank import bank_of, resting_bank
from pmwvc_core.law.port.plain_master import PlainEnergies, PlainMaster, PlainMasterParams
from pmwvc_core.law.port.port_filters import Filtered, FilteredParams, NoFilter
from pmwvc_core.law.port.sensing import NEVER_NS, Sensing
from pmwvc_core.law.port.strict_state import (
    Node,
    StrictEnergies,
    StrictMaster,
    StrictMasterParams,
    Under,
)
from pmwvc_core.law.port.velocity_filter import (
    resting_complementary,
    resting_exact,
    resting_in_force,
    velocity_params,
)
from pmwvc_core.law.position.error import PositionParams
from pmwvc_core.law.position.feedback import NoPosition, position_lent
from pmwvc_core.law.position.plain import resting_budgeted, resting_published
from pmwvc_core.law.position.strict import resting_on_strict
from pmwvc_core.law.safety.hand_brake import RETURN_S as DEVICE_LETS_GO_S
from pmwvc_core.law.safety.hand_brake import brake_stiffness
from pmwvc_core.law.safety.limits import LARGEST, REACH, limits_params, resting_limits
from pmwvc_core.law.user_tick import User, UserParams
from pmwvc_core.law.vectors import Vector
from pmwvc_core.law.wave.anti_aliasing import filter_params, resting_filter
from pmwvc_core.law.wave.hold import Hold
from pmwvc_core.law.wave.wave import MatrixImpedance, impedance
from pmwvc_core.master.position.lags import filter_lag_s, hold_lag_s
from pmwvc_core.params import MasterParams
from pmwvc_core.scenario import scenario as scenarios
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.limits import largest_wave, wave_of_speed

NEVER = 1 << 62  # ticks
NONE = NoFilter(0)


def made_impedance(b: Any) -> Any:
    """Return a wave impedance for the laws."""
    if not isinstance(b, impedances.MatrixImpedance):
        return impedance(float(b))
    twice, over = (2.0 * b).root(), (2.0 / b).root()
    return MatrixImpedance(
        _rows(b.matrix),
        _rows(b.inverse().matrix),
        _rows(twice.matrix),
        _rows(over.matrix),
        tuple(range(len(b.values))),
    )


def _rows(matrix: Any) -> tuple[Vector, ...]:
    return tuple(tuple(row) for row in np.asarray(matrix).tolist())


def arrivals_params(
    controller: str, channel: str, b: Any, *, timeout_s: float, lets_go_s: float, store_j: float
) -> ArrivalsParams:
    """Return the rules of a receiver of a port of this impedance [N s/m], whose brake lets go in
    so much time after an outage [s], and whose playout begins with so much energy [J].
    """
    strict, waves = is_strict(controller, channel), has_waves(controller)
    repaid = float(wave_of_speed(b, REPAID_M_S))
    return ArrivalsParams(
        timeout_s,
        float(largest_wave(b, waves=waves)),
        is_zeroing(controller, channel),
        strict,
        PlayoutParams(repaid, lets_go_s, store_j),
    )


def user_params(
    user: "scenarios.User",
    *,
    controller: str,
    channel: str,
    packet_s: float,
    answer_tick: int,
    workspace_m: float | None = None,
) -> UserParams:
    """Return the parameters of a user's force loop."""
    master, b = user.master, user.impedance
    strict = is_strict(controller, channel)
    arrivals = arrivals_params(
        controller,
        channel,
        b,
        timeout_s=user.safety.timeout_s,
        lets_go_s=DEVICE_LETS_GO_S,
        store_j=master.store_j,
    )
    stiffness = brake_stiffness(impedances.smallest(b)) if strict else 0.0
    reach = LARGEST if workspace_m is None else REACH * workspace_m
    return UserParams(
        FrameParams(master.rate_drop, answer_tick, master.tick_s),
        packing_params(master.deadband),
        arrivals,
        _master_params(master, b, arrivals, strict=strict),
        limits_params(user.safety, master.tick_s, packet_s, reach, stiffness),
    )


def _master_params(
    master: MasterParams, b: Any, arrivals: ArrivalsParams, *, strict: bool
) -> StrictMasterParams | PlainMasterParams:
    impedance_ = made_impedance(b)
    position = _position_params(master, impedance_, strict=strict)
    filters = filters_params(master, impedance_)
    if strict:
        return StrictMasterParams(
            impedance_, master.tick_s, filters, position, master.position.is_on, arrivals.playout
        )
    chosen = filter_params(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    ticks = master.rate_drop if master.ramps else 1
    return PlainMasterParams(
        impedance_, master.tick_s, master.frame_s, ticks, chosen, filters, position
    )


def resting_user(user: "scenarios.User", p: UserParams, axes: int, packet_s: float) -> User:
    """Return a user's force loop at rest."""
    nothing, master = (0.0,) * axes, user.master
    timeout_s = user.safety.timeout_s
    strict = p.arrivals.plays_on
    return User(
        Frames(0, 0),
        master.frame_s,
        resting_packing(axes),
        start_of(strict, timeout_s, packet_s),
        no_packet(axes),
        0,
        _resting_master(master, p, axes, strict=strict),
        resting_limits(nothing, p.limits),
        Sensing(nothing, NEVER_NS, 0),
        NEVER,
        False,
    )


def no_packet(axes: int) -> Packet:
    """Return what stands for the newest packet before the first."""
    rest = (0.0,) * axes
    flags = (False, False, False, False)
    return Packet(0, 0, 0.0, rest, rest, 0.0, rest, *flags, (), 0, False, 0, 0)


def filters_params(master: MasterParams, b: Any) -> FilteredParams | NoFilter:
    """Return the parameters of the filters at a port; those of the velocity are nearest."""
    own = master.velocity_filter
    if not own.is_on and not master.bank.is_on:
        return NONE
    velocity = velocity_params(master) if own.is_on else NONE
    in_force = own.is_on and own.in_force
    far = bank_of(master) if master.bank.is_on else NONE
    near, force = (NONE, velocity) if in_force else (velocity, NONE)
    return FilteredParams(near, far, force, b)


def resting_filters(master: MasterParams, p: Any, axes: int) -> Filtered | NoFilter:
    """Return these filters at rest."""
    if not isinstance(p, FilteredParams):
        return NONE
    near: Any = NONE
    if master.velocity_filter.is_on and not master.velocity_filter.in_force:
        splits = master.velocity_filter.splits
        near = (resting_complementary if splits else resting_exact)(axes, p.near)
    far = resting_bank(axes, p.far) if master.bank.is_on else NONE
    force = resting_in_force(axes, p.force) if master.velocity_filter.in_force else NONE
    return Filtered(near, far, force, (0.0,) * axes, 0.0)


def _resting_master(
    master: MasterParams, p: UserParams, axes: int, *, strict: bool
) -> StrictMaster | PlainMaster:
    rest = (0.0,) * axes
    position = _resting_position(master, p.port.position, rest, strict=strict)
    filters = resting_filters(master, p.port.filters, axes)
    waves = rest, rest, rest
    if strict:
        return StrictMaster(
            Node(position_lent(position, p.port.position), 0.0, 0.0, 0.0),
            filters,
            position,
            waves,
            rest,
            rest,
            (resting_counts(0.0),) * axes,
            rest,
            Under(rest, rest, True, False),
            0.0,
            (False, False),
            StrictEnergies(0.0, 0.0, 0.0),
        )
    energies = PlainEnergies(0.0, 0.0, 0.0, 0.0, 0.0)
    hold, filter_ = (
        Hold(rest, rest, rest, 0),
        resting_filter(master.filter, axes, p.port.filter),
    )
    return PlainMaster(hold, filter_, filters, position, waves, rest, rest, rest, energies)


def _position_params(master: MasterParams, b: Any, *, strict: bool) -> PositionParams | NoPosition:
    position = master.position
    if not position.is_on:
        return NoPosition(0)
    lags = (0.0, 0.0) if strict else (float(filter_lag_s(master)), hold_lag_s(master))
    return PositionParams(
        b,
        master.tick_s,
        master.frame_s,
        *lags,
        position.of_residual,
        master.rate_drop,
        float(position.gain),
        position.adapts,
        float(position.storage_j),
        float(position.most_j),
    )


def _resting_position(master: MasterParams, p: Any, rest: Vector, *, strict: bool) -> Any:
    if not isinstance(p, PositionParams):
        return p
    if strict:
        return resting_on_strict(rest)
    published = master.position.as_published
    return resting_published(rest) if published else resting_budgeted(rest, p)
