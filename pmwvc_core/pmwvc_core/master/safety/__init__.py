# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The safety limits between controller and device: the limiter, its states, changes allowed."""
