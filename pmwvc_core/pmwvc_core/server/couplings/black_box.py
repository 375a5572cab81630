# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``unknown``: a black-box environment that is asked for forces.

Position and velocity go in, a force comes out; the port is in
:mod:`pmwvc_core.server.black_box.port`. A compensation treats the energy of late decoding;
passivity depends on it.
"""

from pmwvc_core.params import ServerParams
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.couplings.record import Coupling
from pmwvc_core.server.couplings.sampled import least_impedance


def _passive(params: ServerParams) -> bool:
    return COMPENSATIONS.of(params.compensation).passive(params)


RECORD = Coupling(
    name="unknown",
    words="The environment is a black box: the server port accounts for the energy of late "
    "decoding, and its compensation limits it.",
    linear="unknown",
    black_box=True,
    parameters=("compensation",),
    passive=_passive,
    least_impedance=least_impedance,
)
