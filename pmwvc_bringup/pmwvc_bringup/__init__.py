# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios, session runner and command line."""

INTERRUPTS: list[int] = []  # all that came: a library may swallow one while it is loaded
