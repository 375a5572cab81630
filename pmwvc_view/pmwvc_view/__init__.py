# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The live page: a session shown in a browser, and people who take part in it."""

SNAPSHOT_S = 0.016
