# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The helpers of the tests: sessions, loops, networks and strategies that several files share."""
