# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a sweep of networks as a page: a row for each network and channel."""

import numpy as np

from benchmark.networks import Found, Group
from pmwvc_core.numeric import Array
from pmwvc_core.words import count, listed

PAGE = "benchmark_networks.md"
LEAST_J = -1e-9  # a balance below it is a violation, by whatever amount
ROUNDING_J = 1e-15  # shown as 0
NAMED = 3  # violations named
HEAD = """# Energy on every network

The task of the [benchmark](benchmark.md) with default gains, {seconds:g} s a session, the same
hands and packet outcomes for all channels. Minimum energy balance of uplink, downlink and hand
port of each user, with the declared storage, at every server step. Written by {origin}.

"""
Sweep = dict[Group, Found]


def page(found: Sweep, origin: str) -> str:
    """Return verdicts in words and the table."""
    if not found:
        return "No session has been finished.\n"
    head = HEAD.format(origin=origin, seconds=next(iter(found)).duration_s)
    return f"{head}{verdicts(found)}\n{table(found)}"


def verdicts(found: Sweep) -> str:
    """Return a sentence for each channel: violations with network and seed."""
    lines = []
    for channel in dict.fromkeys(group.channel for group in found):
        each = [
            (least, group.network, seed)
            for group, one in found.items()
            if group.channel == channel
            for seed, least in zip(group.seeds, one.least_j, strict=True)
        ]
        below = sorted(one for one in each if one[0] < LEAST_J)
        sessions = count(len(each), "session")
        if not below:
            lines.append(
                f"- `{channel}`: no balance below {1e9 * LEAST_J:g} nJ in any of {sessions}; the "
                f"minimum is {min(each)[0]:.2g} J."
            )
            continue
        worst = [f"`{name}` seed {seed} {1e3 * least:.3g} mJ" for least, name, seed in below]
        more = " and others" if len(worst) > NAMED else ""
        lines.append(
            f"- `{channel}`: a balance below {1e9 * LEAST_J:g} nJ in {len(below)} of {sessions}, "
            f"on {count(len({name for _, name, _ in below}), 'network')}: "
            f"{listed(worst[:NAMED])}{more}."
        )
    return "\n".join(lines) + "\n"


def table(found: Sweep) -> str:
    """Return a row for each network, its cells with a value for each channel."""
    channels = list(dict.fromkeys(group.channel for group in found))
    lines = [
        f"Each cell: {' / '.join(f'`{channel}`' for channel in channels)}; medians, largest in "
        "brackets where there are more sessions than one.",
        "",
        "| network | minimum balance [mJ] | offset at the end [mm] | peak force [N] "
        "| step of force [N] |",
        "|---|---|---|---|---|",
    ]
    for network in dict.fromkeys(group.network for group in found):
        cells = [_cells(found, network, channel) for channel in channels]
        lines.append(
            "| " + " | ".join((network, *map(" / ".join, zip(*cells, strict=True)))) + " |"
        )
    return "\n".join(lines) + "\n"


def _cells(found: Sweep, network: str, channel: str) -> list[str]:
    """Return the cells of a network and channel."""
    of = [one for g, one in found.items() if (g.network, g.channel) == (network, channel)]
    if not of:
        return ["-"] * 4
    least = np.concatenate([one.least_j for one in of])
    numbers = (
        1e3 * np.concatenate([one.apart_m for one in of]),
        np.concatenate([one.peak_n for one in of]),
        np.concatenate([one.step_n for one in of]),
    )
    return [
        f"{1e3 * least.min():.3g}" if least.min() < -ROUNDING_J else "0",
        *(f"{np.median(each):.2f}" + _largest(each) for each in numbers),
    ]


def _largest(each: Array) -> str:
    return f" ({each.max():.2f})" if len(each) > 1 else ""
