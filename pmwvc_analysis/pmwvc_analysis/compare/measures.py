# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of a comparison (docs/file_format.md): one row of numbers per session. Unknown
measures are None.

Stability and passivity are those of the verdicts, ``k_max`` that of the exact model, stiffness and
resonance (where the session was stable) and free space those of :mod:`.rendered`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.compare.rendered import RenderedCurve, free_space, rendering
from pmwvc_analysis.traces import sums
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.arrivals import left_out
from pmwvc_analysis.traces.felt import felt
from pmwvc_analysis.verdicts import stability
from pmwvc_analysis.verdicts.oscillation import beyond
from pmwvc_analysis.verdicts.passivity import part_words, passivity
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

NOISE_HZ = 20.0
MEASURES = (
    "stable", "instability", "passive", "active_part", "k_max", "k_felt", "first_peak_hz",
    "mass_free_kg", "damping_free_n_s_m", "free_hz", "coherency_rms_m", "force_error_rms_n",
    "energy_min_j", "force_noise_n", "force_peak_n", "force_step_max_n",
    "force_least_n", "dropout_s", "left_out",
)  # fmt: skip


def least_balance(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Any]:
    """Return the lowest balance over every port that decides, which that is, and the session's
    verdict.

    The links alone do not decide: a server that decodes a step late, or a compensation that
    stretches a wave, generates energy behind a passive link.
    """
    found = passivity(traces, scenario, budget(traces, scenario))
    ports = [finding for finding in found.findings if finding.decides and finding.judged_s]
    if not ports:
        return {"passive": None, "active_part": None, "energy_min_j": None}
    worst = min(ports, key=lambda finding: finding.least_j)
    owner = "" if worst.part == SERVER else f"{worst.owner}: "
    part = f"{owner}{part_words(worst)}" if worst.least_j < 0.0 else None
    return {"passive": found.session, "active_part": part, "energy_min_j": worst.least_j}


@dataclass
class Compared:
    """One session of a comparison.

    ``settings`` are the parameters by which it differs from the others; ``folder`` is where it is
    on disk, relative to the comparison's folder where it is inside; ``tuning`` tells where a
    baseline has its parameters from.
    """

    label: str
    settings: dict[str, Any]
    traces: SessionTraces
    scenario: Scenario
    folder: str = ""
    tuning: str | None = None
    measures: dict[str, Any] = field(default_factory=dict)
    rendered: RenderedCurve | None = None


def measured(entry: Compared) -> Compared:
    """Fill in the measures of an entry and return it."""
    traces, scenario = entry.traces, entry.scenario
    found = entry.measures = measures(traces, scenario)
    # Whether the loops had the phases of live ones; a replay has those of its recording.
    answer = traces.metadata.get("replay", {}).get("answer_ticks", "0")
    live = traces.live or int(answer) > 0
    found["k_max"] = largest_stiffness(scenario, live=live)
    if found["stable"]:
        own = entry.rendered = rendering(traces, scenario, live=live)
        found |= {"k_felt": own.k_felt, "first_peak_hz": own.first_peak_hz}
    if (free := free_space(scenario)) is not None:
        names = "mass_free_kg", "damping_free_n_s_m", "free_hz"
        found |= zip(names, free, strict=True)
    return entry


def measures(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Any]:
    """Return the numbers of one session; those from models are still None."""
    judged, saved = stability.verdict(traces, scenario), left_out(traces, scenario)
    noise = [force_noise_n(user, traces.duration_s) for user in traces.users]
    felt_by = [felt(traces, user, scenario) for user in traces.users]
    peaks = [float(np.linalg.norm(user.f_applied, axis=-1).max()) for user in traces.users]
    return dict.fromkeys(MEASURES) | {
        "stable": judged.stable,
        "instability": judged.instability,
        **least_balance(traces, scenario),
        "coherency_rms_m": coherency_m(traces),
        "force_error_rms_n": force_error_n(traces),
        "force_noise_n": _extreme(max, noise),
        "force_peak_n": sums.number(max(peaks)) if peaks else None,
        "force_step_max_n": _extreme(max, [each.force_step_max_n for each in felt_by]),
        "force_least_n": _extreme(min, [each.force_least_n for each in felt_by]),
        "dropout_s": _extreme(max, [each.dropout_s for each in felt_by]),
        "left_out": float(np.mean(list(saved.values()))) if saved else None,
    }


def _extreme(of: Callable[..., Any], values: Sequence[float | None]) -> float | None:
    """Return the largest or the least of what is known."""
    known = [value for value in values if value is not None]
    return float(of(known)) if known else None


def largest_stiffness(scenario: Scenario, *, live: bool) -> float | None:
    """Return the largest stable contact stiffness of the exact model [N/m], None without one."""
    from pmwvc_analysis.models.stability import k_max

    try:
        return k_max(scenario, live=live).first
    except (PmwvcError, np.linalg.LinAlgError):  # not linear, or no such controller
        return None


def coherency_m(traces: SessionTraces) -> float | None:
    """Return the RMS distance of the devices from their avatars [m]; None: not known."""
    away = [found.error for user in traces.users if (found := apart(traces, user)) is not None]
    return sums.rms(np.concatenate(away)) if away else None


def force_error_n(traces: SessionTraces) -> float | None:
    """Return the RMS of the forces rendered less those at the contacts [N]; None: not known."""
    server = traces.server
    if server is None:
        return None
    users = [user for user in traces.users if user.name in server.users]
    rows = [force_error(user, server, server.users.index(user.name)) for user in users]
    return sums.rms(np.concatenate(rows)) if rows else None


def force_error(user: UserTraces, server: ServerTraces, index: int) -> Array:
    """Return F_m - F_s at the server's steps while the user is coupled ``(steps, dof)`` [N]."""
    coupled = (server.state[index] == Presence.COUPLED) & (server.time_s <= user.time_s[-1])
    rendered = user.f_applied[user.rows_at(server.time_s[coupled])]
    return np.asarray(rendered - server.f_s[index][coupled])


def force_noise_n(user: UserTraces, duration_s: float) -> float | None:
    """Return the RMS of the rendered force beyond what hands do, in the second half [N]."""
    if not np.isfinite(user.f_applied).all():
        return None
    fast = beyond(user.f_applied, user.tick_s, NOISE_HZ)
    return sums.rms(fast[user.time_s > 0.5 * duration_s])
