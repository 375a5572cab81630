# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of waves, made from parameters."""

from typing import Any

import numpy as np

from pmwvc_core.controllers.plugged_local import PluggedLocalParams
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import NOTHING, Nothing
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.port.filter_bank import ACTS, SpringDamper, bank_of, resting_bank
from pmwvc_core.law.port.master import PlainMaster, PlainMasterParams
from pmwvc_core.law.port.port_filters import (
    Filtered,
    FilteredParams,
    InForce,
    InWaves,
    VelocityParams,
    same_gain,
)
from pmwvc_core.law.port.strict_master import StrictMaster, StrictMasterParams
from pmwvc_core.law.position.energy_tank import resting_tank
from pmwvc_core.law.position.error import PositionParams, resting_error
from pmwvc_core.law.position.feedback import Budgeted, OnStrict, Published
from pmwvc_core.law.vectors import Vector
from pmwvc_core.law.wave.filter_and_hold import (
    Hold,
    filter_params,
    resting_cascade,
    resting_filter,
    sections_of,
)
from pmwvc_core.law.wave.wave import MatrixImpedance, impedance
from pmwvc_core.params import MasterParams
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.design.aliasing import delay_of
from pmwvc_core.wave.design.velocity_filter_design import high_pass, low_pass


def made_impedance(b: Any) -> Any:
    """Return a wave impedance for the laws."""
    if not isinstance(b, impedances.MatrixImpedance):
        return impedance(float(b))
    pair = _rows(b.matrix), _rows(b.inverse().matrix)
    roots = _rows((2.0 * b).root().matrix), _rows((2.0 / b).root().matrix)
    axes, values = tuple(range(len(b.values))), tuple(b.values.tolist())
    return MatrixImpedance(*pair, *roots, axes, values, _rows(b.axes.T), _rows(b.axes))


def _rows(matrix: Any) -> tuple[Vector, ...]:
    return tuple(tuple(row) for row in np.asarray(matrix).tolist())


def waves_params(
    master: MasterParams, b: Any, playout: PlayoutParams, *, strict: bool
) -> StrictMasterParams | PlainMasterParams:
    """Return the parameters of a master behind an impedance [N s/m]."""
    impedance_ = made_impedance(b)
    position: Any = NOTHING
    if master.position.is_on:
        position = position_params(master, impedance_, strict=strict)
    filters = _filters_params(master, impedance_)
    if strict:
        of_position = position, master.position.is_on, lent_of(position)
        return StrictMasterParams(impedance_, master.tick_s, filters, *of_position, playout)
    chosen = filter_params(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    ticks = master.rate_drop if master.ramps else 1
    return PlainMasterParams(
        impedance_, master.tick_s, master.frame_s, ticks, chosen, filters, position
    )


def lent_of(position: Any) -> float:
    """Return the energy that position feedback of these parameters borrows at the start [J]."""
    return position.lent_j if isinstance(position, PositionParams) else 0.0


def _filters_params(master: MasterParams, b: Any) -> FilteredParams | Nothing:
    """Return the parameters of the filters at a port; those of the velocity are nearest."""
    own = master.velocity_filter
    if own.splits and master.bank.is_on:
        raise ParameterError(
            f"bank.kind = {master.bank.kind}: must be none with velocity_filter.kind = "
            f"{own.kind}, which splits the wave itself"
        )
    if not own.is_on and not master.bank.is_on:
        return NOTHING
    velocity: Any = NOTHING
    if own.is_on:
        high, twice = sections_of(high_pass(master)), own.splits  # through the pair twice
        low = sections_of(low_pass(master)) if twice else ()
        velocity = VelocityParams(high * (1 + twice), low, own.share, master.tick_s)
    far: Any = NOTHING
    if master.bank.is_on:
        local = master.local_model
        place = ACTS.index(local.acts), local.begins_m, master.tick_s
        model: Any = SpringDamper(local.stiffness, local.damping, *place)
        if local.is_plugin:
            model = PluggedLocalParams(local, sum(b.values) / len(b.values), *place)
        far = bank_of(master, model)
    in_force = own.is_on and own.in_force
    near, force = (NOTHING, velocity) if in_force else (velocity, NOTHING)
    return FilteredParams(near, far, force, b)


def resting_filters(master: MasterParams, p: Any, axes: int) -> Filtered | Nothing:
    """Return these filters at rest."""
    if not isinstance(p, FilteredParams):
        return NOTHING
    rest, near, force = (0.0,) * axes, p.near, p.force
    if isinstance(force, VelocityParams):
        force = InForce((resting_cascade(force.high),) * axes, 0.0)
    if isinstance(near, VelocityParams):
        low, high = ((resting_cascade(each),) * axes for each in (near.low, near.high))
        near = InWaves(low, low, high, rest, rest, 0.0)
    far = resting_bank(axes, p.far) if master.bank.is_on else NOTHING
    return Filtered(near, far, force, rest, same_gain(p.impedance, 0.0))


def resting_waves(
    master: MasterParams, p: StrictMasterParams | PlainMasterParams, axes: int
) -> StrictMaster | PlainMaster:
    """Return a master at rest."""
    rest, strict = (0.0,) * axes, isinstance(p, StrictMasterParams)
    position = resting_position(master, p.position, rest, strict=strict)
    filters = resting_filters(master, p.filters, axes)
    waves = rest, rest, rest
    if isinstance(p, StrictMasterParams):
        return StrictMaster(
            p.lent_j, 0.0, 0.0, 0.0,
            filters, position, waves, rest, rest, (resting_counts(0.0),) * axes,
            rest, rest, rest, True, False, 0.0, False, False, 0.0, 0.0, 0.0,
        )  # fmt: skip
    hold, filter_ = Hold(rest, rest, rest, 0), resting_filter(master.filter, axes, p.filter)
    return PlainMaster(hold, filter_, filters, position, waves, rest, rest, rest, *(0.0,) * 5)


def position_params(master: MasterParams, b: Any, *, strict: bool) -> PositionParams:
    """Return the parameters of position feedback, with the lags [s] of filter and hold.

    A packet carries the end of its frame, which is (M-1)/2 T_c later than the mean of the frame:
    tau - (M-1)/2 T_c is left of the group delay tau of the anti-aliasing filter; the first-order
    hold comes (M-1)/2 T_c late, the other does not. Equations: docs/theory.md 11.7.
    """
    position, tick_s, drop, lags = master.position, master.tick_s, master.rate_drop, (0.0, 0.0)
    if not strict:
        tau, late = (
            delay_of(master.filter, tick_s=tick_s, rate_drop=drop),
            0.5 * (drop - 1) * tick_s,
        )
        lags = tau - late, late if master.ramps else 0.0
    return PositionParams(
        b, tick_s, master.frame_s, *lags, position.of_residual, drop,
        float(position.gain), position.adapts, float(position.storage_j), float(position.most_j),
    )  # fmt: skip


def resting_position(master: MasterParams, p: Any, rest: Vector, *, strict: bool) -> Any:
    """Return position feedback at rest."""
    if not isinstance(p, PositionParams):
        return p
    error = resting_error(rest)
    if strict:
        return OnStrict(error, rest, 0.0, 0.0, 0.0, rest, 0.0)
    if master.position.as_published:
        return Published(error, 0.0)
    return Budgeted(error, resting_tank(rest, p.lent_j))
