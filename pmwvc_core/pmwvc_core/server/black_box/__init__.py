# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments as black boxes: position and velocity in, force out (App. C)."""

from pmwvc_core.server.black_box.interface import BlackBox, EnvironmentSetup

__all__ = ["BlackBox", "EnvironmentSetup"]
