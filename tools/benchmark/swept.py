# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a sweep of networks as a page: a row for each network and channel."""

import numpy as np

from benchmark.networks import Found, Group
from pmwvc_core.plural import count, listed

PAGE = "benchmark_networks.md"
LEAST_J = -1e-9  # a balance below it is a violation, by whatever amount
ROUNDING_J = 1e-15  # shown as 0
NAMED = 12  # violations named
HEAD = """# Energy on every network

Written by {origin}. The task of the [benchmark](benchmark.md) with the
default gains, {seconds:g} s a session, the same hands and packet fates for both channels; least
balance of each way of each user's channel and from hand to server, at every step of the server.

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
                f"least is {min(each)[0]:.2g} J."
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
    """Return a row for each network and channel."""
    lines = [
        "| network | channel | sessions | least balance | below -1 nJ | apart at the end, median "
        "(largest) [mm] | peak force, median (largest) [N] | step of force, median (largest) "
        "[N] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for network in dict.fromkeys(group.network for group in found):
        for channel in dict.fromkeys(group.channel for group in found):
            of = [one for g, one in found.items() if (g.network, g.channel) == (network, channel)]
            if not of:
                continue
            least = np.concatenate([one.least_j for one in of])
            apart = 1e3 * np.concatenate([one.apart_m for one in of])
            peak = np.concatenate([one.peak_n for one in of])
            step = np.concatenate([one.step_n for one in of])
            cells = (
                network,
                f"`{channel}`",
                len(least),
                f"{1e3 * least.min():.3g} mJ" if least.min() < -ROUNDING_J else "0",
                int(np.sum(least < LEAST_J)),
                f"{np.median(apart):.2f} ({apart.max():.2f})",
                f"{np.median(peak):.2f} ({peak.max():.2f})",
                f"{np.median(step):.2f} ({step.max():.2f})",
            )
            lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines) + "\n"
