# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Live sessions: the plan of the nodes, their processes, the runner, and the checks before it."""
