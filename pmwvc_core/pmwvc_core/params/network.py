# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of one direction of one user's network link."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter


@dataclass(frozen=True)
class LinkParams(Validated):
    """Network conditions of one direction."""

    delay_s: float = parameter(0.0, "s", "constant one-way delay", low=0.0, high=60.0)
    jitter: str = parameter(
        "none",
        "-",
        "spread of the delay: uniform (delay +- jitter_s), normal (standard deviation jitter_s), "
        "trace (from a file)",
        choices=("none", "uniform", "normal", "trace"),
    )
    jitter_s: float = parameter(0.0, "s", "size of the spread", low=0.0, high=10.0)
    trace_file: str = parameter(
        "", "-", "trace: file with columns time and delay; delays follow it, in a loop"
    )
    trace_scale: float = parameter(
        1.0,
        "s per unit of the file",
        "trace: factor to seconds (half a round trip in ms: 0.0005)",
        above=0.0,
        high=3600.0,
    )
    loss: float = parameter(0.0, "-", "probability that a packet is lost", low=0.0, high=1.0)
    duplicate: float = parameter(
        0.0, "-", "probability that a packet arrives twice", low=0.0, high=1.0
    )
    rate_limit_bps: float = parameter(0.0, "bit/s", "rate limit (0: none)", low=0.0, high=1e12)
    queue_packets: int = parameter(
        100, "-", "packets that may wait for the rate limit; more are dropped", low=1, high=100000
    )
    keep_order: bool = parameter(
        True,
        "-",
        "a later packet waits for an earlier one; with jitter that makes the delay longer and "
        "narrower (normal, 20 and 5 ms: 20.5 +- 4.6 ms at 125 packets/s, 23.0 +- 3.6 at 500)",
    )
    effects: str = parameter(
        "",
        "-",
        "effects of other packages, name:number=value:... each, separated by blanks",
    )
