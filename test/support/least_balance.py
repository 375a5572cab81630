# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The least balance of a user's session beside what was declared to be stored at the start."""


def least_j(energy):
    """Of both directions and of the port of the hand; zero or more where nothing was made [J]."""
    return min(each.minimum_j + each.declared_j for each in energy.parts.values())
