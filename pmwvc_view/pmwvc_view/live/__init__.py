# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session of ROS nodes as a page sees it: found in the graph, read, changed, taken part in."""
