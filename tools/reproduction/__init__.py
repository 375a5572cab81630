# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The dissertation's figures and numbers, computed again; started by ``make figures``."""
