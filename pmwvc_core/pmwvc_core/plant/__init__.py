# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The person's side in simulation: device, hand, recorded operators, task."""
