# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded session once more, with other parameters: same hands, same fate of every packet."""
