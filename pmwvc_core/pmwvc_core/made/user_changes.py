# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a force loop that change in flight, at a frame start.

Waves carry the same power whatever the impedance, so that may change at any time, and so may
position feedback, local model, rate drop and deadband. Another filter, hold or velocity filter
starts at zero: what the old one held is lost, never gained. Sums of energy go on.
"""

import dataclasses
from typing import Any

from pmwvc_core.law.channel.silence import LATENESSES
from pmwvc_core.law.family import Nothing
from pmwvc_core.law.port.filter_bank import Bank, BankFilters, changed_local, resting_bank
from pmwvc_core.law.port.plain_master import PlainMaster
from pmwvc_core.law.port.port_filters import Filtered, FilteredParams
from pmwvc_core.law.port.strict_master import StrictMasterParams
from pmwvc_core.law.user_tick import User, UserParams
from pmwvc_core.law.vectors import Vector
from pmwvc_core.law.wave.anti_aliasing import resting_filter
from pmwvc_core.law.wave.hold import Hold
from pmwvc_core.made.waves import lent_of, position_params, resting_filters, resting_position
from pmwvc_core.params import MasterParams

# What may change without a new beginning of what is around the port.
GOES_ON = ("impedance", "position", "bank", "local_model", "rate_drop", "deadband")


def begins_anew(old: MasterParams, new: MasterParams) -> bool:
    """Tell whether the channel of a master starts at zero with a change."""
    kept = {name: getattr(old, name) for name in GOES_ON}
    return dataclasses.replace(new, **kept) != old


def changed_master(
    s: User, p: UserParams, q: UserParams, old: MasterParams, new: MasterParams
) -> tuple[User, UserParams]:
    """Take other parameters of a master over.

    Parameters
    ----------
    p, q
        Of the force loop as it runs, and as it would be made now.
    old, new
        Of the master.
    """
    port, of_port = s.port, q.port
    # A brake that holds keeps its stiffness, and a receiver what it was made for.
    limits = q.limits._replace(brakes=p.limits.brakes, brake_stiffness=p.limits.brake_stiffness)
    if hasattr(of_port, "filters"):
        anew = begins_anew(old, new)
        filters, of_filters = _filters(port.filters, p.port.filters, of_port.filters, new, anew)
        position, of_position = _position(port.position, of_port, new, (0.0,) * len(port.x))
        of_port = of_port._replace(filters=of_filters, position=of_position)
        port = port._replace(filters=filters, position=position)
        if isinstance(port, PlainMaster):
            port, of_port = _plain(port, p.port, of_port, new, anew)
        else:
            lends, lent_j = not isinstance(position, Nothing), lent_of(of_position)
            of_port = of_port._replace(lends=lends, lent_j=lent_j)
    return s._replace(port=port), q._replace(port=of_port, limits=limits, arrivals=p.arrivals)


def _plain(
    port: PlainMaster, was: Any, wanted: Any, new: MasterParams, anew: bool
) -> tuple[PlainMaster, Any]:
    """Start hold and filter at zero, or keep them with their design."""
    if not anew:
        kept = {"filter": was.filter, "hold_ticks": was.hold_ticks, "frame_s": was.frame_s}
        return port, wanted._replace(**kept)
    rest = (0.0,) * len(port.x)
    chosen = resting_filter(new.filter, len(rest), wanted.filter)
    return port._replace(hold=Hold(rest, rest, rest, 0), filter=chosen), wanted


def _filters(s: Any, p: Any, q: Any, new: MasterParams, anew: bool) -> tuple[Any, Any]:
    """Return the filters of a port and their parameters; which there are never changes."""
    if not isinstance(q, FilteredParams):
        return s, q
    if not anew:
        q = q._replace(near=p.near, force=p.force)
    rest = resting_filters(new, q, len(s.held))
    assert isinstance(rest, Filtered)
    near, force = s.near, s.force
    if anew:
        near, force = _counting_on(rest.near, near), _counting_on(rest.force, force)
    return Filtered(near, _bank(s.far, p.far, q.far), force, s.held, s.gains), q


def _counting_on(rest: Any, before: Any) -> Any:
    """Return a filter at rest that goes on counting."""
    return rest._replace(kept_j=before.kept_j) if hasattr(rest, "kept_j") else rest


def _bank(s: Any, p: Any, q: Any) -> Any:
    """Start another split at zero, another spring at rest."""
    if not isinstance(s, Bank):
        return s
    local = changed_local(s.local, p.local, q.local)
    if _split(q) != _split(p):
        s = resting_bank(len(s.low_up), q)._replace(energies=s.energies)
    return s._replace(local=local)


def _split(p: BankFilters) -> tuple[Any, ...]:
    return p.low_up, p.low_down, p.high_up, p.high_down


def _position(s: Any, wanted: Any, new: MasterParams, rest: Vector) -> tuple[Any, Any]:
    """Give position feedback its parameters; make it where there was none."""
    strict = isinstance(wanted, StrictMasterParams)
    if isinstance(s, Nothing):
        return resting_position(new, wanted.position, rest, strict=strict), wanted.position
    return s, position_params(new, wanted.impedance, strict=strict)


def changed_safety(s: User, p: UserParams, q: UserParams) -> tuple[User, UserParams]:
    """Take other limits over, and another time of silence; ``q`` is the force loop as it would be
    made now.
    """
    limits = q.limits._replace(brakes=p.limits.brakes, brake_stiffness=p.limits.brake_stiffness)
    arrivals = p.arrivals._replace(timeout_s=q.arrivals.timeout_s)
    silence = s.arrivals.silence
    of_packets_s = 3.0 * silence.interval_s + LATENESSES * silence.lateness_s
    limit_ns = round(max(arrivals.timeout_s, of_packets_s) * 1e9)
    s = s._replace(arrivals=s.arrivals._replace(silence=silence._replace(limit_ns=limit_ns)))
    return s, p._replace(limits=limits, arrivals=arrivals)
