# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every parameter of a link that may change in flight: its packets then have the fate that they
have on a link that had the new value from the beginning. The control is the link without it. That
a session changes its links: ``test_settled_changes.py``.
"""

from pathlib import Path

import numpy as np
import pytest

from pmwvc_bringup import scenarios
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams, specs

TRACE = Path(__file__).parents[1] / "data" / "cicv5g_urban_n78.txt"
CHANGE_S, PERIOD_NS = 1.0, 8_000_000
BLANKS = {"schedule", "effects", "jitter_quantiles"}  # no change can name them
FILES = {"trace_file", "trace_column"}  # read as the scale of the trace is
GE, SLOTS = "ge_p=0.1 ge_r=0.3", "slot_min_s=0.002 slot_max_s=0.02"
OUTAGES = "handover_s=1 handover_outage=1"
FULL = "rate_limit_bps=100000"
# Parameter: new value, and what else is set.
ROWS = {
    "delay_s": (0.03, ""),
    "jitter": ("normal", "jitter_s=0.004"),
    "jitter_s": (0.005, ""),
    "jitter_shape": (4.0, "jitter=gamma jitter_s=0.004"),
    "jitter_correlation": (0.7, "jitter=normal jitter_s=0.004"),
    "trace_scale": (0.002, f"jitter=trace trace_file={TRACE} trace_scale=0.001"),
    "loss": (0.2, ""),
    "loss_correlation": (0.6, "loss=0.2"),
    "ge_p": (0.1, "ge_r=0.3"),
    "ge_r": (0.2, "ge_p=0.1"),
    "ge_bad": (0.5, GE),
    "ge_good": (0.1, GE),
    "duplicate": (0.2, ""),
    "duplicate_correlation": (0.6, "duplicate=0.2"),
    "corrupt": (0.2, ""),
    "corrupt_correlation": (0.6, "corrupt=0.2"),
    "reorder": (0.2, "keep_order=false"),
    "reorder_correlation": (0.6, "reorder=0.3 keep_order=false"),
    "rate_limit_bps": (250_000.0, ""),
    "rate_overhead_bytes": (42, "rate_limit_bps=250000"),
    "queue_packets": (3, FULL),
    "queue_bytes": (500, FULL),
    "slot_min_s": (0.018, SLOTS),
    "slot_max_s": (0.04, SLOTS),
    "handover_s": (1.0, "handover_step_s=0.02"),
    "handover_step_s": (0.02, "handover_s=1"),
    "handover_outage": (0.5, f"{OUTAGES} handover_outage_min_s=0.1 handover_outage_max_s=0.2"),
    "handover_outage_min_s": (0.15, f"{OUTAGES} handover_outage_max_s=0.2"),
    "handover_outage_max_s": (0.3, f"{OUTAGES} handover_outage_max_s=0.1"),
    "handover_loss": (0.5, "handover_s=1 handover_loss_s=0.1"),
    "handover_loss_s": (0.1, "handover_s=1 handover_loss=0.5"),
    "keep_order": ("false", "jitter=normal jitter_s=0.008"),
}
# For so long what was before is seen.
REMEMBERED_S = {"jitter_correlation": 1.0, "queue_packets": 2.0, "queue_bytes": 2.0}
REMEMBERED_S |= dict.fromkeys(("ge_p", "ge_r", "corrupt_correlation"), 1.0)
IN_THE_MEAN = (
    "queue_packets",
    "queue_bytes",
    "slot_min_s",
    "slot_max_s",
)  # a queue keeps its phase


def params(*settings):
    """Return the link of a user with these settings."""
    return scenarios.load("wall", settings_texts=["channel=plain", *settings]).users[0].link_up


def fates(name, first, then):
    """Return outcome, cause and delay [s] of each packet and copy from the change on."""
    link, found = Link(first, seed=(3, 0, 0)), []
    lasts_s = 5.0 if name in (*REMEMBERED_S, *IN_THE_MEAN) else 3.0
    for now_ns in range(0, round(lasts_s * 1e9), PERIOD_NS):
        if now_ns == CHANGE_S * 1e9:
            link.configure(then)
        link.arrivals(now_ns)
        for sent in link.send(None, now_ns):
            delay_s = (sent.time_due_ns - now_ns) * 1e-9 if sent.time_due_ns else 0.0
            found.append((now_ns, sent.kind, sent.cause, delay_s))
    found = np.array(found, float).T
    return found[1:, found[0] >= (CHANGE_S + REMEMBERED_S.get(name, 0.0)) * 1e9]


def apart(one, other):
    """Return by how much packets differ."""
    return float(np.abs(one - other).max()) if one.shape == other.shape else np.inf


def means(packets):
    """Return the share that did not come, mean and scatter of the delay [0.1 s]."""
    missing, delay_s = packets[0] > 0, packets[2]
    return np.array([missing.mean(), 10.0 * delay_s.mean(), 10.0 * delay_s.std()])


@pytest.mark.parametrize("name", ROWS)
def test_packets_after_a_change_fare_as_on_a_link_that_began_with_it(name):
    value, others = ROWS[name]
    others = [f"link.{each}" for each in others.split()]
    before, after = params(*others), params(*others, f"link.{name}={value}")
    changed, fresh, old = (
        fates(name, *of) for of in ((before, after), (after, after), (before, before))
    )
    if name in IN_THE_MEAN:
        changed, fresh, old = map(means, (changed, fresh, old))
        assert apart(changed, fresh) <= 0.2 * apart(changed, old)
        assert apart(changed, old) > 0.02
    else:
        assert apart(changed, fresh) <= 1e-6
        assert apart(changed, old) > 1e-4


def test_no_parameter_is_left_out():
    assert {*ROWS, *BLANKS, *FILES} == set(specs(LinkParams))
