# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Exact models: what the parameters of a scenario imply, without simulating it."""
