# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure as data, and its renderers: SVG, PNG, and numbers for the report's script."""
