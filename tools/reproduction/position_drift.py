# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The position error that grows in a minute of carrying, without and with position feedback
(App. E, Eq. 3): a figure and a table that the dissertation does not have.

The balance is E_hand, work of the hand less what the server got: what a paid feedback gives out on
the way down, the way up has kept, or its declared storage lends.
"""

import numpy as np

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.traces.sums import rms
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces
from reproduction import draw_position_drift
from reproduction.figure import Figure, Values
from reproduction.scenarios import scenario

# As in carry_16ms.yaml, with the anti-aliasing filter of App. B.
HANDS = {"stiffness": 120.0, "damping": 15.0, "squeeze": 2.0}
MODEL = {
    "safety.max_force": 3.3,
    "link.delay_s": 0.016,
    "master.filter.kind": "first_order",
    "master.filter.pole_rad_s": 50.0,  # of App. B
}
LINKS: dict[str, Values] = {
    "no_loss": {},
    "loss": {"link.loss": 0.05},
    "loss_patient": {"link.loss": 0.05, "safety.timeout_s": 0.2},
}
STORED: Values = {  # as budgeted, with a declared storage and the gain of the round trip
    "master.position.storage_j": 0.005,
    "master.position.adapts": True,
}
FINAL_S = 0.5


def drift(parameters: Values) -> Values:
    """Return the distances over time and the numbers of every link and feedback."""
    data: Values = {}
    numbers: Values = {}
    for link, changed in parameters["links"].items():
        for feedback in parameters["feedbacks"]:
            traces = _session(parameters, changed, feedback)
            time_s, apart = _apart(traces)
            kept = slice(None, None, parameters["every_steps"])
            data[f"{link}/{feedback}"] = {"time_s": time_s[kept], "apart_mm": 1e3 * apart[kept]}
            for name, value in _numbers(traces, time_s, apart).items():
                numbers[f"{name}_{link}_{feedback}"] = value
    return {"data": data, "numbers": numbers}


def _session(parameters: Values, changed: Values, feedback: str) -> SessionTraces:
    values = {
        **parameters["model"],
        **changed,
        "master.position.feedback": "budgeted" if feedback == "stored" else feedback,
        "master.position.gain": parameters["gain"],
        **(parameters["stored"] if feedback == "stored" else {}),
    }
    return simulate_one(
        scenario(
            values,
            users=2,
            task="carry",
            operator=parameters["hands"],
            duration_s=parameters["duration_s"],
        )
    )


def _apart(traces: SessionTraces) -> tuple[Array, Array]:
    """Return times and how much closer than their avatars the devices are ``(step,)`` [m]."""
    both = [apart(traces, user) for user in traces.users]
    left, right = (found for found in both if found is not None)
    steps = min(len(left.time_s), len(right.time_s))
    return left.time_s[-steps:], left.error[-steps:, 0] - right.error[-steps:, 0]


def _numbers(traces: SessionTraces, time_s: Array, apart: Array) -> Values:
    last = time_s >= time_s[-1] - FINAL_S
    force = [np.abs(user.f_applied[user.time_s >= time_s[-1] - FINAL_S]) for user in traces.users]
    least = min(entry.joint.minimum_j for entry in user_energies(traces))
    spent = [user.accounts.get("position_spent", np.zeros(1))[-1] for user in traces.users]
    return {
        "rms_mm": 1e3 * (rms(apart[:, np.newaxis]) or 0.0),
        "end_mm": 1e3 * float(apart[last].mean()),
        "force_n": float(np.mean(force)),
        "spent_mj": 1e3 * float(np.sum(spent)),
        "least_balance_mj": 1e3 * least,
    }


FIGURES = (
    Figure(
        "position_drift",
        "Device and avatar after a minute of carrying, with position feedback",
        "Scenario carry_16ms for 60 s. A loss of three packets in a row counts as silence after "
        "30 ms. stored: budgeted, with a declared storage of 5 mJ and K_p = 0.5 sqrt(2b)/tau from "
        "the round trip.",
        {
            "model": MODEL,
            "hands": HANDS,
            "links": LINKS,
            "feedbacks": ["none", "printed", "budgeted", "integral", "stored"],
            "stored": STORED,
            "gain": 20.0,
            "duration_s": 60.0,
            "every_steps": 25,
        },
        drift,
        draw_position_drift.drift,
    ),
)
