# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Services of the nodes: the only part of the core that touches clock, system or ROS."""
