# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of a comparison (docs/file_format.md): one row of numbers per session. Unknown
measures are None.

Stability and passivity are those of the verdicts, ``k_max`` that of the exact model. Stiffness and
resonance (where the session was stable) are from the exact model where one holds and leaves no
effect of the links out, else from a simulated press; free space is that of :mod:`.probes`.
"""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.compare.probes import free_space, pressed_stiffness
from pmwvc_analysis.models.linear import left_out as unmodelled
from pmwvc_analysis.models.stability import k_max
from pmwvc_analysis.traces import sums
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.arrivals import left_out
from pmwvc_analysis.traces.felt import felt
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_analysis.verdicts import stability
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame import Presence
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

COLUMNS = (  # measure, heading of the report and of a terminal (empty: not there), factor
    ("k_max", "largest stable stiffness [N/m]", "K max [N/m]", 1.0),
    ("k_felt", "rendered stiffness [N/m]", "rendered [N/m]", 1.0),
    ("k_felt_from", "stiffness from", "", 1.0),
    ("first_peak_hz", "first resonance [Hz]", "peak [Hz]", 1.0),
    ("mass_free_kg", "mass in free space [kg]", "free [kg]", 1.0),
    ("damping_free_n_s_m", "damping in free space [N s/m]", "free [N s/m]", 1.0),
    ("coherency_rms_m", "offset of the device from its avatar, RMS [mm]", "offset [mm]", 1e3),
    ("force_error_rms_n", "force error, RMS [N]", "force err [N]", 1.0),
    ("energy_min_j", "lowest energy balance of a port [mJ]", "balance [mJ]", 1e3),
    ("buzz_n", "buzz, RMS of the force above 60 Hz [N]", "buzz [N]", 1.0),
    ("force_peak_n", "largest force [N]", "", 1.0),
    ("force_step_max_n", "largest change of force in 1 ms [N]", "step [N]", 1.0),
    ("blows", "changes above 0.3 N in 1 ms", "blows", 1.0),
    ("force_least_n", "least force while pressing [N]", "", 1.0),
    ("dropout_s", "force below half of the undisturbed one [ms]", "dropout [ms]", 1e3),
    ("left_out", "packets left out by a deadband [%]", "left out [%]", 100.0),
)
MEASURES = "stable", "instability", "passive", "active_part", "free_hz", *(c[0] for c in COLUMNS)
FREE = "mass_free_kg", "damping_free_n_s_m", "free_hz"
WORST = "force_step_max_n", "blows", "dropout_s", "buzz_n"  # those of the worst user


def least_balance(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Any]:
    """Return the lowest balance over every port that decides, which that is, and the session's
    verdict.

    The links alone do not decide: a server that decodes a step late, or a compensation that
    stretches a wave, generates energy behind a passive link.
    """
    found = passivity(traces, scenario, None)
    ports = [each for each in found.ports if each.passive is not None or each.least_j < 0.0]
    if not ports:
        return {"passive": None, "active_part": None, "energy_min_j": None}
    worst = min(ports, key=lambda finding: finding.least_j)
    owner = "" if worst.part == SERVER else f"{worst.owner}: "
    part = f"{owner}{worst.words}" if worst.least_j < 0.0 else None
    return {"passive": found.session, "active_part": part, "energy_min_j": worst.least_j}


@dataclass
class Compared:
    """One session of a comparison.

    ``settings`` are the parameters by which it differs from the others; ``folder`` is where it is
    on disk, relative to the comparison's folder where it is inside.
    """

    label: str
    settings: dict[str, Any]
    traces: SessionTraces
    scenario: Scenario
    folder: str = ""
    measures: dict[str, Any] = field(default_factory=dict)


def measured(entry: Compared) -> Compared:
    """Fill in the measures of an entry and return it."""
    traces, scenario = entry.traces, entry.scenario
    found = entry.measures = measures(traces, scenario)
    # Whether the loops had the phases of live ones; a replay has those of its recording.
    answer = traces.metadata.get("replay", {}).get("answer_ticks", "0")
    live = traces.live or int(answer) > 0
    found["k_max"] = largest_stiffness(scenario, live=live)
    if found["stable"]:
        found |= rendering(scenario, live=live)
    if (free := free_space(scenario)) is not None:
        found |= zip(FREE, free, strict=True)
    return entry


def measures(traces: SessionTraces, scenario: Scenario | None) -> dict[str, Any]:
    """Return the numbers of one session; those from models are still None."""
    judged, saved = stability.verdict(traces, scenario), left_out(traces, scenario)
    felt_by = [felt(traces, user, scenario) for user in traces.users]
    peaks = [float(np.linalg.norm(user.f_applied, axis=-1).max()) for user in traces.users]
    return dict.fromkeys(MEASURES) | {
        "stable": judged.stable,
        "instability": judged.instability,
        **least_balance(traces, scenario),
        "coherency_rms_m": coherency_m(traces),
        "force_error_rms_n": force_error_n(traces),
        "force_peak_n": sums.number(max(peaks)) if peaks else None,
        "force_least_n": _extreme(min, [each.force_least_n for each in felt_by]),
        **{name: _extreme(max, [getattr(each, name) for each in felt_by]) for name in WORST},
        "left_out": float(np.mean(list(saved.values()))) if saved else None,
    }


def _extreme(of: Callable[..., Any], values: Sequence[float | None]) -> float | None:
    """Return the largest or the least of what is known."""
    known = [value for value in values if value is not None]
    return float(of(known)) if known else None


def rendering(scenario: Scenario, *, live: bool) -> dict[str, Any]:
    """Return stiffness and first resonance rendered to the first user, and where they are from."""
    if not unmodelled(scenario):
        with contextlib.suppress(PmwvcError, np.linalg.LinAlgError):  # not linear, or not stable
            own = transparency(scenario, np.ones(1), live=live).rendered
            return {
                "k_felt": own.k_felt,
                "first_peak_hz": own.first_peak_hz,
                "k_felt_from": "model",
            }
    k = pressed_stiffness(scenario)
    return {"k_felt": k, "first_peak_hz": None, "k_felt_from": "press" if k else None}


def largest_stiffness(scenario: Scenario, *, live: bool) -> float | None:
    """Return the largest stable contact stiffness of the exact model [N/m], None without one."""
    with contextlib.suppress(PmwvcError, np.linalg.LinAlgError):  # not linear, no such controller
        return k_max(scenario, live=live).first
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
