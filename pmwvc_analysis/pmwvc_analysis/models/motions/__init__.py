# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions of a loop: those that no force resists, the model without them, and equal users."""
