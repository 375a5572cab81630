# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The causes of a state of the safety limits, as numbers."""

NONE = 0
WAITING = 1
SOFT_START = 2
SILENT = 3
RELEASED = 4
TOO_FAST = 5
NOT_FINITE = 6
RUNAWAY = 7
OUTSIDE = 8
DEVICE_SILENT = 9
DEVICE_LOST = 10
UNRECEIVED = 11
LATE = 12
