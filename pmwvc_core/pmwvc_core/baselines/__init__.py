# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Other controllers to compare with, built from the blocks of ``server``."""
