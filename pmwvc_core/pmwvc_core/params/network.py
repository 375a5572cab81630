# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of one direction of one user's network link."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter


def _probability(description: str, default: float = 0.0) -> float:
    return parameter(default, "0..1", description)  # type: ignore[no-any-return]


def _correlation(of: str) -> float:
    text = f"correlation of {of} from packet to packet"
    return parameter(0.0, ">= 0 and < 1", text)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class LinkParams(Validated):
    """Network conditions of one direction."""

    delay_s: float = parameter(0.0, "0..60 s", "constant one-way delay")
    jitter: str = parameter(
        "uniform",
        (
            *("none", "uniform", "normal", "pareto", "gamma", "lognormal", "quantiles", "table"),
            "trace",
        ),
        "spread of the delay; jitter_s is the half width (uniform), deviation (normal, "
        "pareto), mean (gamma) or median (lognormal); table: drawn from a file; trace: "
        "follows it",
    )
    jitter_s: float = parameter(0.0, "0..10 s", "size of the spread; 0: none")
    jitter_shape: float = parameter(
        0.0, "0..100",
        "shape of gamma (0: 2), sigma of lognormal (0: 0.5), tail > 2 of pareto (0: 3)",
    )  # fmt: skip
    jitter_correlation: float = _correlation("the jitter")
    jitter_quantiles: str = parameter("", "-", "probability:seconds: 0:0.001 0.5:0.002 1:0.02")
    trace_file: str = parameter("", "-", "trace, table: file of times and delays, or IRTT JSON")
    trace_scale: float = parameter(
        1.0, "> 0 and <= 3600 s per unit of the file",
        "trace, table: factor to seconds (half a round trip in ms: 0.0005; of IRTT 0.5)",
    )  # fmt: skip
    trace_column: str = parameter(
        "", "-", "trace, table: column (empty: delay, rtt, latency); of IRTT: rtt, send, receive"
    )
    loss: float = _probability("probability that a packet is lost")
    loss_correlation: float = _correlation("the loss")
    ge_p: float = _probability("Gilbert-Elliott: probability of a change from good to bad state")
    ge_r: float = _probability("Gilbert-Elliott: probability of the change back", 1.0)
    ge_bad: float = _probability("Gilbert-Elliott: loss in the bad state (1-h)", 1.0)
    ge_good: float = _probability("Gilbert-Elliott: loss in the good state (1-k)")
    duplicate: float = _probability("probability that a packet arrives twice")
    duplicate_correlation: float = _correlation("the duplication")
    corrupt: float = _probability("probability that one bit of a packet is flipped")
    corrupt_correlation: float = _correlation("the corruption")
    reorder: float = _probability("probability of a skipped delay; needs keep_order = false")
    reorder_correlation: float = _correlation("the reordering")
    rate_limit_bps: float = parameter(0.0, "0..1e12 bit/s", "rate limit (0: none)")
    rate_overhead_bytes: int = parameter(0, "0..10000 byte", "rate limit: header (UDP: 42)")
    queue_packets: int = parameter(100, "1..100000", "rate limit: packets that may wait at most")
    queue_bytes: int = parameter(
        0, "0..1e9 byte", "bytes that may wait for the rate limit, headers included (0: no limit)"
    )
    slot_min_s: float = parameter(0.0, "0..10 s", "slots: shortest interval of packets")
    slot_max_s: float = parameter(0.0, "0..10 s", "slots: longest interval (0: no slots)")
    handover_s: float = parameter(0.0, "0..3600 s", "interval of satellites' hand-overs (0: none)")
    handover_step_s: float = parameter(0.0, "0..10 s", "hand-over: largest step of the delay")
    handover_outage: float = _probability("hand-over: probability of an outage")
    handover_outage_min_s: float = parameter(0.0, "0..60 s", "hand-over: shortest outage")
    handover_outage_max_s: float = parameter(0.0, "0..60 s", "hand-over: longest outage")
    handover_loss: float = _probability("hand-over: probability of loss around it")
    handover_loss_s: float = parameter(0.0, "0..60 s", "hand-over: time with it, before and after")
    keep_order: bool = parameter(
        True, "-", "later packets wait for earlier ones: jitter makes delays longer and narrower"
    )
    schedule: str = parameter(
        "",
        "-",
        "changes on a timeline from the first packet, TIME SETTINGS; ...: 5 outage; 5.5 lte; "
        "20 delay_s=0.02..0.2 loss=0.1; 30 base; 40 repeat",
    )
    effects: str = parameter("", "-", "effects of other packages, name:number=value:... name:...")
