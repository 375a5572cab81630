# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``summary.json``: the verdicts and numbers of one session, the same keys whatever its source.

What each key means: docs/file_format.md. Where device and avatar start apart (grip), that constant
distance is taken out of ``coherency_rms_m`` and ``drift_m``.
"""

from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.result import Budget
from pmwvc_analysis.events import events, limits
from pmwvc_analysis.recording.links import DROPPED, came_out, reordered
from pmwvc_analysis.traces import holes
from pmwvc_analysis.traces.apart import apart, kept_text
from pmwvc_analysis.traces.arrivals import left_out
from pmwvc_analysis.traces.felt import felt
from pmwvc_analysis.traces.stages import stages
from pmwvc_analysis.traces.sums import final, number, percentiles, rms
from pmwvc_analysis.verdicts import check, endings, passivity, stability
from pmwvc_analysis.verdicts.outcomes import outcomes
from pmwvc_analysis.verdicts.passivity import Passivity
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, SessionTraces, UserTraces

PREDICTION_KEYS = (
    "spectral_radius", "stable", "any_delay", "loop_gain", "aliasing_gain", "k_felt",
    "mass_felt", "environment_limited", "left_out",
)  # fmt: skip
NAMES = {"least_j": "least_balance_j", "counts_j": "encoder_bound_j", "unjudged": "not_judged"}


@np.errstate(over="ignore", invalid="ignore")  # a recording may hold any number
def summary(
    traces: SessionTraces, scenario: Scenario | None, energies: Budget | None = None
) -> dict[str, Any]:
    """Return the summary of a single run."""
    from pmwvc_analysis.prediction.prediction import prediction

    whole, seen = traces, events.complete(traces, scenario)
    ended = endings.endings(traces, seen, scenario)
    traces = endings.judged(traces, ended)
    judged = stability.verdict(traces, scenario)
    found = passivity.passivity(traces, scenario, energies)
    limited = limits.withheld(traces, scenario)
    cuts = [each.text for each in ended if each.interrupts]
    cuts.append(endings.shortened(whole, scenario))
    result: dict[str, Any] = {
        "scenario": scenario.name if scenario else None,
        "source": traces.source,
        "duration_s": whole.duration_s,
        "judged_until_s": traces.duration_s,
        "interrupted": [text for text in cuts if text],
        "strangers": [str(each["what"]) for each in seen if each["kind"] == "stranger"],
        "controller": scenario.controller if scenario else None,
        "parameters": scenario.flat() if scenario else {},
        "stable": judged.stable,
        "instability": judged.instability,
        "stability": {"text": judged.why, "oscillation_m_s": number(judged.oscillation_m_s)},
        "active": [passivity.component(each) for each in found.components] if energies else None,
        "passivity": _passivity(found),
        "object": _object(traces),
        "users": [
            _user(user, traces, found, limited.get(user.name))
            | felt(traces, user, scenario)._asdict()
            for user in traces.users
        ],
        "links": [_link(fates) for _, fates in sorted(traces.fates.items())],
        "receptions": _receptions(traces, scenario),
        "prediction": prediction(scenario, live=traces.live)
        if scenario
        else dict.fromkeys(PREDICTION_KEYS),
        "recording": {
            "messages": {topic: count["messages"] for topic, count in traces.counts.items()},
            "missing": {topic: count["missing"] for topic, count in traces.counts.items()},
            "holes": [hole._asdict() for hole in holes.holes(traces)],
        },
        "alignment": traces.metadata.get("alignment", {}),
        "events": seen,
    }
    for user in result["users"]:
        user["ended"] = next((each.text for each in ended if each.user == user["name"]), None)
        user["kept_apart"] = (scenario and kept_text(user["kept_apart_m"], scenario)) or None
    found_out = outcomes(scenario, result, stages(traces, scenario)) if scenario else []
    result["outcomes"] = [each._asdict() for each in found_out]
    result["verdict"] = [line._asdict() for line in check.lines(result)]
    reasons = [line["text"] for line in result["verdict"] if line["fails"]]
    result["check"] = {"passed": not reasons, "reasons": reasons}
    return result


def _object(traces: SessionTraces) -> dict[str, Any]:
    if (server := traces.server) is None:
        return dict.fromkeys(("position_final_m", "velocity_rms_m_s", "path_error_rms_m"))
    end_s = max((float(u.time_s[-1]) for u in traces.users), default=float(server.time_s[-1]))
    return {
        "position_final_m": final(server.x_o, server.time_s, end_s),
        "velocity_rms_m_s": rms(server.xd_o),
        "path_error_rms_m": rms(server.x_o - server.target),
    }


def _passivity(found: Passivity) -> dict[str, Any]:
    return {
        "passive": found.session,
        "ports": [_finding(each) for each in found.ports],
        "components": [_finding(each) for each in found.components],
        "text": {
            owner: passivity.verdict(found, owner)
            for owner in dict.fromkeys(each.owner for each in found.ports)
        },
    }


def _finding(found: Finding) -> dict[str, Any]:
    plain = {n: number(v) if isinstance(v, float) else v for n, v in vars(found).items()}
    named = {NAMES.get(name, name): value for name, value in plain.items()}
    return named | {"not_judged": [each._asdict() for each in found.unjudged]}


def _user(
    user: UserTraces, traces: SessionTraces, found: Passivity, limited: limits.Withheld | None
) -> dict[str, Any]:
    server, end_s = traces.server, float(user.time_s[-1])
    index = server.users.index(user.name) if server and user.name in server.users else None
    away = apart(traces, user)
    return {
        "name": user.name,
        "passive": found.passive(user.name),
        "force_final_n": final(user.f_applied, user.time_s, end_s),
        "force_commanded_final_n": final(user.f_m, user.time_s, end_s),
        "velocity_final_m_s": final(user.xd_m, user.time_s, end_s),
        "force_peak_n": number(np.linalg.norm(user.f_applied, axis=-1).max()),
        "avatar_force_final_n": final(server.f_s[index], server.time_s, end_s)
        if server is not None and index is not None
        else None,
        "coherency_rms_m": rms(away.error) if away else None,
        "drift_m": final(away.error, away.time_s, end_s) if away else None,
        "drift_change_m": final(away.error, away.time_s, end_s, np.ptp) if away else None,
        "kept_apart_m": final(away.kept, away.time_s, end_s) if away else None,
        **_ticks(user),
        "lateness_us": percentiles(user.lateness_s, 1e6),
        "compute_us": percentiles(user.compute_s, 1e6),
        "safety_events": int(user.safety_events),
        "environment_limited": {"energy_j": limited.energy_j, "position_m": limited.position_m}
        if limited
        else None,
    }


def _ticks(user: UserTraces) -> dict[str, Any]:
    """Return how many ticks ran, were skipped by the loop and were not recorded, and the rate of
    those that ran, in the time in which the master ran and was recorded.
    """
    steps, missing = np.diff(user.tick), holes.gaps(user)
    seen = steps > 0  # a master that is started again counts from zero
    seen[missing] = False
    ran_s = float(np.diff(user.time_s)[seen].sum())
    return {
        "ticks": len(user.tick),
        "ticks_skipped": int((steps[seen] - 1).sum()),
        "ticks_missing": int((steps[missing] - 1).sum()),
        "tick_rate_hz": number(int(seen.sum()) / ran_s) if ran_s else None,
    }


def _link(fates: FateTraces) -> dict[str, Any]:
    out = came_out(fates)
    span_s = float(np.ptp(fates.time_out_ns[out])) * 1e-9 if out.any() else 0.0
    return {
        "name": fates.link, "sent": int((fates.fate != FateKind.DUPLICATE).sum()),
        "received": int(out.sum()), "lost": int((fates.fate == FateKind.LOST).sum()),
        "duplicated": int((fates.fate == FateKind.DUPLICATE).sum()),
        "reordered": int(reordered(fates).sum()),
        "corrupted": int((fates.cause == Cause.CORRUPTION).sum()),
        "dropped": int(np.isin(fates.fate, DROPPED).sum()),
        "delay_s": percentiles((fates.time_out_ns - fates.time_in_ns)[out].astype(float) * 1e-9),
        "rate_hz": number((out.sum() - 1) / span_s) if span_s > 0.0 else None,
    }  # fmt: skip


def _receptions(traces: SessionTraces, scenario: Scenario | None) -> list[dict[str, Any]]:
    """Return the entries of ``receptions`` of a summary."""
    saved, found = left_out(traces, scenario), list[dict[str, Any]]()
    for link, received in sorted(traces.receptions.items()):
        passage = {name: number(value) for name, value in received.passage.items()}
        path = None if passage["round_trip"] is None else passage
        of_link = {"counts": received.counts, "path": path, "left_out": saved.get(link)}
        found.append({"name": link} | of_link)
    return found
