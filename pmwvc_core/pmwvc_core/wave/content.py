# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the packets of a controller carry, by its name.

Controllers with waves send waves both ways. All others send velocities up, forces or positions
down, and say so by ``FLAG_DIRECT``.
"""

WITH_WAVES = ("pmwvc",)


def has_waves(controller: str) -> bool:
    """Tell whether a controller, by name, joins its ends by wave variables."""
    return controller in WITH_WAVES
