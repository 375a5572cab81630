# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions that are marred: a device that shakes, a recorder that missed what happened."""

import numpy as np

from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


def oscillating(
    traces: SessionTraces,
    *,
    rms_m_s: float,
    hertz: float,
    rate_per_s: float = 0.0,
    during_s: tuple[float, float] = (0.0, np.inf),
) -> SessionTraces:
    """Shake the first user's device: RMS velocity at mid-session, growing with ``rate_per_s``."""
    user = traces.users[0]
    time_s = user.time_s
    size = np.sqrt(2.0) * rms_m_s * np.exp(rate_per_s * (time_s - traces.duration_s / 2))
    size *= (time_s >= during_s[0]) & (time_s < during_s[1])
    user.xd_m = user.xd_m + (size * np.sin(2 * np.pi * hertz * time_s))[:, np.newaxis]
    return traces


def without_blocks(user: UserTraces, blocks: slice) -> UserTraces:
    """Take blocks out of a master's trace, as a recorder that missed them."""
    ticks = np.zeros(len(user.time_s), dtype=bool)
    ends = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
    for end in ends[blocks]:
        before = ends[ends < end]
        ticks[before[-1] if len(before) else 0 : end] = True
    gone = np.zeros(len(user.block_time_s), dtype=bool)
    gone[blocks] = True
    for name, values in vars(user).items():
        if isinstance(values, np.ndarray) and len(values) in (len(ticks), len(gone)):
            kept = ~ticks if len(values) == len(ticks) else ~gone
            setattr(user, name, values[kept])
    user.reason = [text for text, lost in zip(user.reason, gone, strict=True) if not lost]
    for sums in (user.energy, user.accounts):
        sums.update({name: values[~gone] for name, values in sums.items()})
    return user


def without_steps(server: ServerTraces, steps: slice) -> ServerTraces:
    """Take steps out of the server's trace, as a recorder that missed them."""
    kept = np.ones(len(server.time_s), dtype=bool)
    kept[steps] = False
    for name, values in vars(server).items():
        if isinstance(values, np.ndarray) and len(values):
            setattr(server, name, values[kept])
        elif isinstance(values, list) and name != "users":
            setattr(server, name, [each[kept] for each in values])
        elif isinstance(values, dict):
            setattr(server, name, {key: each[kept] for key, each in values.items()})
    return server
