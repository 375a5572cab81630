# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wave ports with a filter bank, moved by hand."""

import numpy as np

from pmwvc_core.params import BankParams, FilterParams, LocalModelParams, MasterParams

TICK_S = 0.001


def master(kind="complementary", *, impedance=25.0, matrix="", rate_drop=4, **local):
    return MasterParams(
        impedance=impedance,
        impedance_matrix=matrix,
        rate_drop=rate_drop,
        filter=FilterParams(kind="integrate_and_dump"),
        bank=BankParams(kind=kind),
        local_model=LocalModelParams(**local),
    )


def driven(port, motions, *, wave=0.0):
    """Force of a port moved by hand, every frame of 4 ticks hearing the same wave."""
    forces = []
    x = 0.0 * motions[0]
    for k, xd in enumerate(motions):
        if k % 4 == 0:
            port.receive(wave + 0.0 * xd)
        f = port.step(x, xd)
        port.applied(f)
        x = x + TICK_S * xd
        forces.append(f)
    return np.array(forces)
