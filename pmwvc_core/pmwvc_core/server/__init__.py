# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server end: wave ports, couplings (the algebraic loop), contact laws, the object."""

from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.port import WaveServer

__all__ = ["ServerController", "WaveServer"]
