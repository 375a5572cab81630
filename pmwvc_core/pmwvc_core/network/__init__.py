# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The network between the two ends: links, their effects on packets, and the record of fates."""
