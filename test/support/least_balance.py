# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The least balance of a user's session beside what was declared to be stored at the start."""


def least_j(energy):
    """Of both directions and of the port of the hand; zero or more where nothing was made [J]."""
    channel = (each for each in (energy.up, energy.down) if each is not None)
    least = [each.minimum_j + each.storage_j for each in channel]
    return min(energy.joint.minimum_j + energy.storage_j, *least)
