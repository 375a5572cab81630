# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wave variables at run time: transformation, filter and rate drop, hold, impedance, ledgers."""
