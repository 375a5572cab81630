# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The faults that a session may meet, each tried: ``make faults`` writes docs/faults.md."""
