# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The control laws, link models and session simulator; free of ROS except in ``runtime``."""
