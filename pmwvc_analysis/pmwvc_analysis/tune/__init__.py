# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which impedance, filter and hold suit a link and an environment, and what each choice costs."""
