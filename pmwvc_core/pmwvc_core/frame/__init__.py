# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When both ends act, and what they report: phases of a frame, samples, rows."""
