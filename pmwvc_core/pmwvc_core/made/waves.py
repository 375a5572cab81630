# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of waves, made from parameters."""

from collections.abc import Callable
from typing import Any

import numpy as np

import pmwvc_core.law.server.coupled_axes  # noqa: F401, laws of matrices: they join families
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.channel.playout import PlayoutParams
from pmwvc_core.law.family import NOTHING, Nothing
from pmwvc_core.law.port import filter_bank
from pmwvc_core.law.port import port_filters as at_port
from pmwvc_core.law.port.counts import resting_counts
from pmwvc_core.law.port.master import PlainMaster, PlainMasterParams
from pmwvc_core.law.port.port_filters import Filtered, FilteredParams
from pmwvc_core.law.port.strict_master import StrictMaster, StrictMasterParams
from pmwvc_core.law.position.energy_tank import Tank
from pmwvc_core.law.position.error import FeedbackParams, PositionError, Posted
from pmwvc_core.law.position.feedback import Budgeted, OnStrict
from pmwvc_core.law.vectors import Vector
from pmwvc_core.law.wave import filter_and_hold as rates
from pmwvc_core.law.wave.wave import ImpedanceMatrix, impedance
from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams, MasterParams
from pmwvc_core.server.black_box import rows_of
from pmwvc_core.wave import impedance as impedances
from pmwvc_core.wave.aliasing import delay_of
from pmwvc_core.wave.filter_design import bank_filters, design
from pmwvc_core.wave.velocity_filter_design import passing


def made_impedance(b: Any) -> Any:
    """Return a wave impedance for the laws."""
    if not isinstance(b, impedances.MatrixImpedance):
        return impedance(float(b))
    of, matrix = b.values, b.with_values
    pair = rows_of(matrix(of)), rows_of(matrix(1.0 / of))
    roots = rows_of(matrix(np.sqrt(2.0 * of))), rows_of(matrix(np.sqrt(2.0 / of)))
    axes, values = tuple(range(len(of))), tuple(of.tolist())
    return ImpedanceMatrix(*pair, *roots, axes, values, rows_of(b.axes.T), rows_of(b.axes))


def through(law: Callable[..., Any], b: Any, *signals: Array) -> Array:
    """Return what a law of :mod:`pmwvc_core.law.wave.wave` makes of signals ``(..., dof)`` behind
    an impedance [N s/m].
    """
    by_axis = (tuple(np.moveaxis(signal, -1, 0)) for signal in signals)
    return np.stack(law(made_impedance(b), *by_axis), axis=-1)


def made_filter(params: FilterParams, axes: int, tick_s: float, rate_drop: int) -> tuple[Any, Any]:
    """Return a filter at rest, and its parameters: its sections, or the ticks M."""
    nothing = (0.0,) * axes
    if params.means:
        return rates.Mean(nothing, 0), rate_drop
    sections = rates.sections_of(design(params, tick_s=tick_s))
    return rates.Sectioned(nothing, (rates.resting_cascade(sections),) * axes), sections


def made_waves(
    master: MasterParams, b: Any, axes: int, playout: PlayoutParams, *, strict: bool
) -> tuple[StrictMaster | PlainMaster, StrictMasterParams | PlainMasterParams]:
    """Return a master behind an impedance [N s/m], at rest, and its parameters."""
    impedance_, rest = made_impedance(b), (0.0,) * axes
    waves, lent_j = (rest, rest, rest), 0.0
    filters, of_filters = _made_filters(master, impedance_, rest)
    position: Any = NOTHING
    of_position: Any = NOTHING
    if master.position.is_on:
        of_position = position_params(master, impedance_, strict=strict)
        lent_j = of_position.lent_j
        error = PositionError([Posted(0, rest, 0.0)], *(rest,) * 9)
        if strict:
            position = OnStrict(error, rest, rest, 0.0, 0.0, rest, 0.0)
        else:
            position = Budgeted(error, Tank(lent_j, *(rest,) * 4))
    if strict:
        state = StrictMaster(
            lent_j, 0.0, 0.0, 0.0,
            filters, position, waves, rest, rest, (resting_counts(0.0),) * axes,
            rest, rest, rest, 1.0, 0.0, rest, True, False, 1.0, 0.0, False, False, 0.0, 0.0, 0.0,
        )  # fmt: skip
        of = of_filters, of_position, master.position.is_on, lent_j, master.rises, playout
        return state, StrictMasterParams(impedance_, master.tick_s, *of)
    filter_, chosen = made_filter(master.filter, axes, master.tick_s, master.rate_drop)
    hold = rates.Hold(rest, rest, rest, 0)
    plain = PlainMaster(hold, filter_, filters, position, waves, rest, rest, rest, *(0.0,) * 5)
    times = master.tick_s, master.frame_s, master.rate_drop if master.ramps else 1
    return plain, PlainMasterParams(impedance_, *times, chosen, of_filters, of_position)


def _made_filters(
    master: MasterParams, b: Any, rest: Vector
) -> tuple[Filtered | Nothing, FilteredParams | Nothing]:
    """Return the filters at a port, at rest, and their parameters; those of the velocity are
    nearest.
    """
    own, axes = master.velocity_filter, len(rest)
    if own.splits and master.bank.is_on:
        raise ParameterError(
            f"bank.kind = {master.bank.kind}: must be none with velocity_filter.kind = "
            f"{own.kind}, which splits the wave itself"
        )
    if not own.is_on and not master.bank.is_on:
        return NOTHING, NOTHING
    near: tuple[Any, Any] = NOTHING, NOTHING
    far = near
    if own.is_on:
        high, twice = rates.sections_of(passing(master, "high")), own.splits
        low = rates.sections_of(passing(master, "low")) if twice else ()
        high *= 1 + twice  # through the pair twice
        velocity = at_port.VelocityParams(high, low, own.share, master.tick_s)
        lows, highs = ((rates.resting_cascade(each),) * axes for each in (low, high))
        if own.in_force:
            near = at_port.InForce(highs, 0.0), velocity
        else:
            near = at_port.InWaves(lows, lows, highs, rest, rest, 0.0), velocity
    if master.bank.is_on:
        local = master.local_model
        place = filter_bank.ACTS.index(local.acts), local.begins_m, master.tick_s
        model = filter_bank.SpringDamper(local.stiffness, local.damping, *place)
        bank = bank_filters(master.bank, tick_s=master.tick_s)
        sections = [() if each is None else rates.sections_of(each) for each in bank]
        cascades = [(rates.resting_cascade(each),) * axes for each in sections]
        still = filter_bank.LocalModel(rest, rest, 0.0, True, 0.0)
        far = (
            filter_bank.Bank._make([*cascades, still, (0.0,) * 4]),
            filter_bank.BankFilters._make([*sections, model, master.tick_s]),
        )
    states, params = zip(near, far, strict=True)
    return Filtered(*states, rest, (0.0,) * len(b.values)), FilteredParams(*params, b)


def position_params(master: MasterParams, b: Any, *, strict: bool) -> FeedbackParams:
    """Return the parameters of position feedback, with the lags [s] of filter and hold.

    A packet carries the end of its frame, which is (M-1)/2 T_c later than the mean of the frame:
    tau - (M-1)/2 T_c is left of the group delay tau of the anti-aliasing filter; the first-order
    hold comes (M-1)/2 T_c late, the other does not. Equations: docs/theory.md 11.7.
    """
    position, tick_s, drop, lags = master.position, master.tick_s, master.rate_drop, (0.0, 0.0)
    if not strict:
        tau = delay_of(master.filter, tick_s=tick_s, rate_drop=drop)
        late = 0.5 * (drop - 1) * tick_s
        lags = tau - late, late if master.ramps else 0.0
    return FeedbackParams(
        b, tick_s, master.frame_s, *lags, position.of_residual, drop,
        float(position.gain), position.adapts, float(position.storage_j), float(position.most_j),
        not position.as_published,
    )  # fmt: skip
