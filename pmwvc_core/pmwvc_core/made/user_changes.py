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
from pmwvc_core.law.port.filter_bank import Bank, resting_bank
from pmwvc_core.law.port.local_model import changed_local
from pmwvc_core.law.port.port_filters import Filtered, FilteredParams
from pmwvc_core.law.port.strict_master import StrictMasterParams
from pmwvc_core.law.safety.limits import LimitsParams
from pmwvc_core.law.user_tick import User, UserParams
from pmwvc_core.law.wave.anti_aliasing import resting_filter
from pmwvc_core.law.wave.hold import Hold
from pmwvc_core.made.waves import position_params, resting_filters, resting_position
from pmwvc_core.params import MasterParams

# What may change without a new beginning of what is around the port.
GOES_ON = ("impedance", "position", "bank", "local_model", "rate_drop", "deadband")


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
    port, was, wanted = s.port, p.port, q.port
    if hasattr(wanted, "filters"):
        kept = {name: getattr(old, name) for name in GOES_ON}
        anew = dataclasses.replace(new, **kept) != old
        rest, strict = (0.0,) * len(port.x), isinstance(wanted, StrictMasterParams)
        filters, of_filters = _filters(port.filters, was.filters, wanted.filters, new, anew=anew)
        position, of_position = port.position, wanted.position
        if isinstance(position, Nothing):
            position = resting_position(new, of_position, rest, strict=strict)
        else:
            of_position = position_params(new, wanted.impedance, strict=strict)
        port = port._replace(filters=filters, position=position)
        wanted = wanted._replace(filters=of_filters, position=of_position)
        if strict:
            wanted = wanted._replace(lends=not isinstance(position, Nothing))
        elif anew:
            chosen = resting_filter(new.filter, len(rest), wanted.filter)
            port = port._replace(hold=Hold(rest, rest, rest, 0), filter=chosen)
        else:
            held = {"hold_ticks": was.hold_ticks, "frame_s": was.frame_s}
            wanted = wanted._replace(filter=was.filter, **held)
    q = q._replace(port=wanted, limits=_limits(p, q), arrivals=p.arrivals)
    return s._replace(port=port), q


def _filters(s: Any, p: Any, q: Any, new: MasterParams, *, anew: bool) -> tuple[Any, Any]:
    """Return the filters of a port and their parameters; which there are never changes."""
    if not isinstance(q, FilteredParams):
        return s, q
    if not anew:
        q = q._replace(near=p.near, force=p.force)
    rest = resting_filters(new, q, len(s.held))
    assert isinstance(rest, Filtered)
    near, far, force = s.near, s.far, s.force
    if anew:
        near, force = _counting_on(rest.near, near), _counting_on(rest.force, force)
    if isinstance(far, Bank):
        local = changed_local(far.local, p.far.local, q.far.local)
        if q.far[:4] != p.far[:4]:  # another split starts at zero
            far = resting_bank(len(far.low_up), q.far)._replace(energies=far.energies)
        far = far._replace(local=local)
    return Filtered(near, far, force, s.held, s.gains), q


def _counting_on(rest: Any, before: Any) -> Any:
    """Return a filter at rest that goes on counting."""
    return rest._replace(kept_j=before.kept_j) if hasattr(rest, "kept_j") else rest


def _limits(p: UserParams, q: UserParams) -> LimitsParams:
    """Return other limits; a brake that holds keeps its stiffness, a receiver what it was made
    for.
    """
    return q.limits._replace(brakes=p.limits.brakes, brake_stiffness=p.limits.brake_stiffness)


def changed_safety(s: User, p: UserParams, q: UserParams) -> tuple[User, UserParams]:
    """Take other limits over, and another time of silence; ``q`` is the force loop as it would be
    made now.
    """
    silence, timeout_s = s.arrivals.silence, q.arrivals.timeout_s
    of_packets_s = 3.0 * silence.interval_s + LATENESSES * silence.lateness_s
    silence = silence._replace(limit_ns=round(max(timeout_s, of_packets_s) * 1e9))
    arrivals = p.arrivals._replace(timeout_s=timeout_s)
    s = s._replace(arrivals=s.arrivals._replace(silence=silence))
    return s, p._replace(limits=_limits(p, q), arrivals=arrivals)
