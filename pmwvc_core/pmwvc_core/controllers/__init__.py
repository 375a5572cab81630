# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers: one record per controller (record.py), found by its name (library.py)."""
