# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure as data, as PNG and SVG files, and as numbers for the report's script."""
