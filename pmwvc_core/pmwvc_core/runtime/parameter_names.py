# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Names of parameters that nodes write themselves."""

CHANGED_AT_STEP = "changed_at_step"  # of the server: number of the step
