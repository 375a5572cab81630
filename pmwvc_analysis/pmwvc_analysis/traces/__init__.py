# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reading of traces: holes and judged intervals, running sums, reductions to numbers."""
