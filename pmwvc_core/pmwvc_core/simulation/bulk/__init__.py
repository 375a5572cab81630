# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in bulk: the plan of their network, the loop that is compiled, their traces."""
