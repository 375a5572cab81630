# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reports of sessions and comparisons, as self-contained HTML files."""
