# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions beside each other: what is measured of each, tables and files; the pictures are in
``figures``.
"""
