# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdicts on a session: stability, passivity, predictions against measurements."""
