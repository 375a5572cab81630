# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of one direction of one user's network link."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter


def _probability(description: str, default: float = 0.0) -> float:
    return parameter(default, "-", description, low=0.0, high=1.0)  # type: ignore[no-any-return]


def _correlation(of: str) -> float:
    text = f"correlation of {of} of one packet with that of the next"
    return parameter(0.0, "-", text, low=0.0, below=1.0)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class LinkParams(Validated):
    """Network conditions of one direction."""

    delay_s: float = parameter(0.0, "s", "constant one-way delay", low=0.0, high=60.0)
    jitter: str = parameter(
        "uniform",
        "-",
        "spread of the delay: uniform (delay +- jitter_s); normal, pareto, paretonormal (standard "
        "deviation jitter_s); gamma (mean jitter_s) and lognormal (median jitter_s), added to the "
        "delay; quantiles; table (drawn from the delays of a file); trace (follows a file)",
        choices=(
            *("none", "uniform", "normal", "pareto", "paretonormal", "gamma", "lognormal"),
            *("quantiles", "table", "trace"),
        ),
    )
    jitter_s: float = parameter(0.0, "s", "size of the spread; 0: none", low=0.0, high=10.0)
    jitter_shape: float = parameter(
        0.0,
        "-",
        "shape: of gamma (0: 2), sigma of lognormal (0: 0.5), tail index of pareto and "
        "paretonormal, above 2 (0: 3)",
        low=0.0,
        high=100.0,
    )
    jitter_correlation: float = _correlation("the jitter")
    jitter_quantiles: str = parameter(
        "",
        "-",
        "quantiles: probability:seconds from 0 to 1, separated by blanks and joined by straight "
        "lines, added to the delay: 0:0.001 0.5:0.002 0.99:0.01 1:0.02",
    )
    trace_file: str = parameter(
        "",
        "-",
        "trace, table: file with columns time and delay, IRTT JSON, or log of ping; a trace is "
        "followed in a loop",
    )
    trace_scale: float = parameter(
        1.0,
        "s per unit of the file",
        "trace, table: factor to seconds (half a round trip in ms: 0.0005; of ping and IRTT, "
        "whose units are known: 0.5)",
        above=0.0,
        high=3600.0,
    )
    trace_column: str = parameter(
        "",
        "-",
        "trace, table: name of the column of delays (empty: delay, rtt or latency); of IRTT rtt, "
        "send or receive",
    )
    loss: float = _probability("probability that a packet is lost")
    loss_correlation: float = _correlation("the loss")
    ge_p: float = _probability(
        "Gilbert-Elliott: probability to change from the good to the bad state, a packet"
    )
    ge_r: float = _probability(
        "Gilbert-Elliott: probability to change back; a stay in the bad state lasts 1/ge_r "
        "packets",
        1.0,
    )
    ge_bad: float = _probability(
        "Gilbert-Elliott: probability of loss in the bad state (1-h)", 1.0
    )
    ge_good: float = _probability("Gilbert-Elliott: probability of loss in the good state (1-k)")
    markov_p13: float = _probability("four-state loss: from received (1) to lost in a burst (3)")
    markov_p31: float = _probability("four-state loss: from lost in a burst to received", 1.0)
    markov_p32: float = _probability("four-state loss: from lost to received within a burst (2)")
    markov_p23: float = _probability("four-state loss: from received within a burst to lost", 1.0)
    markov_p14: float = _probability("four-state loss: from received to an isolated loss (4)")
    duplicate: float = _probability("probability that a packet arrives twice")
    duplicate_correlation: float = _correlation("the duplication")
    corrupt: float = _probability("probability that one bit of a packet is flipped")
    corrupt_correlation: float = _correlation("the corruption")
    reorder: float = _probability(
        "probability that a packet is sent at once, without delay; needs keep_order = false"
    )
    reorder_gap: int = parameter(
        1, "-", "reordering: only every so many packets may be sent at once", low=1, high=100000
    )
    reorder_correlation: float = _correlation("the reordering")
    rate_limit_bps: float = parameter(0.0, "bit/s", "rate limit (0: none)", low=0.0, high=1e12)
    rate_overhead_bytes: int = parameter(
        0, "byte", "rate limit: header of each packet (UDP, IP, Ethernet: 42)", low=0, high=10000
    )
    rate_cell_bytes: int = parameter(
        0,
        "byte",
        "rate limit: a packet is sent in whole cells (ATM: 48; 0: none)",
        low=0,
        high=65535,
    )
    rate_cell_overhead_bytes: int = parameter(
        0, "byte", "rate limit: header of each cell (ATM: 5)", low=0, high=65535
    )
    queue_packets: int = parameter(
        100, "-", "packets that may wait for the rate limit; more are dropped", low=1, high=100000
    )
    queue_bytes: int = parameter(
        0,
        "byte",
        "bytes that may wait for the rate limit, headers included (0: no limit)",
        low=0,
        high=10**9,
    )
    slot_min_s: float = parameter(
        0.0,
        "s",
        "slots: packets come out only at instants at least this far apart",
        low=0.0,
        high=10.0,
    )
    slot_max_s: float = parameter(
        0.0, "s", "slots: and at most this far (0: no slots)", low=0.0, high=10.0
    )
    slot_packets: int = parameter(
        0, "-", "slots: packets in one slot (0: no limit)", low=0, high=100000
    )
    slot_bytes: int = parameter(
        0, "byte", "slots: bytes in one slot (0: no limit)", low=0, high=10**9
    )
    handover_s: float = parameter(
        0.0, "s", "interval of hand-overs, as of satellites (0: none)", low=0.0, high=3600.0
    )
    handover_step_s: float = parameter(
        0.0, "s", "hand-over: the delay changes, by +- this at most", low=0.0, high=10.0
    )
    handover_outage: float = _probability("hand-over: probability of an outage")
    handover_outage_min_s: float = parameter(
        0.0, "s", "hand-over: shortest outage", low=0.0, high=60.0
    )
    handover_outage_max_s: float = parameter(
        0.0, "s", "hand-over: longest outage", low=0.0, high=60.0
    )
    handover_loss: float = _probability("hand-over: probability of loss around it")
    handover_loss_s: float = parameter(
        0.0, "s", "hand-over: time before and after with that loss", low=0.0, high=60.0
    )
    keep_order: bool = parameter(
        True,
        "-",
        "a later packet waits for an earlier one; with jitter that makes the delay longer and "
        "narrower (normal, 20 and 5 ms: 20.5 +- 4.6 ms at 125 packets/s, 23.0 +- 3.6 at 500)",
    )
    schedule: str = parameter(
        "",
        "-",
        "changes on a timeline from the first packet, TIME SETTINGS; ... each with a network by "
        "name, name=value, delay_s=from..to (a ramp), outage, base or repeat: "
        "5 outage; 5.5 lte; 20 delay_s=0.02..0.2 loss=0.1; 30 base",
    )
    mode: str = parameter(
        "exact",
        "-",
        "exact: probabilities and distributions hold with correlation too; netem: as tc-netem of "
        "Linux does it, faults included",
        choices=("exact", "netem"),
    )
    effects: str = parameter(
        "",
        "-",
        "effects of other packages, name:number=value:... each, separated by blanks",
    )
