# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers and channels on every network preset, tuned alike, judged on others: ``make
benchmark``.
"""
