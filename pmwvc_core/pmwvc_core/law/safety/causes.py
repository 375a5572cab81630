# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The causes of a state of the safety limits, as numbers."""

NONE, WAITING, SOFT_START, SILENT, RELEASED, TOO_FAST, NOT_FINITE, RUNAWAY = range(8)
OUTSIDE, DEVICE_SILENT, DEVICE_LOST, UNRECEIVED, LATE = range(8, 13)
