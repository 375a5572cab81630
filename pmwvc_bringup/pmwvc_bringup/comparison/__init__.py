# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparisons: the scenarios to run, their sessions, and the report of all of them."""
