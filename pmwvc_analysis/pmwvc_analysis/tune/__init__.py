# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The proposal of impedance, filter and hold for a link, and the cost of each choice."""
