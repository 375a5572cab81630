# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings of wave port and contact by name: how the algebraic loop is closed.

The velocity of an avatar depends on the force of its contact and the force on the velocity. A
coupling makes the two consistent in a step of the environment.
"""

from pmwvc_core.server.couplings.library import COUPLINGS
from pmwvc_core.server.couplings.record import Coupling

__all__ = ["COUPLINGS", "Coupling"]
