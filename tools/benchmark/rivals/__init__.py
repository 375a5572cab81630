# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Rivals: controllers of the literature as plug-ins, one file each, with the ranges of a search.

Installed where this folder and ``tools`` are on the path (``PYTHONPATH``).
"""

RIVALS = (
    "two_layer",
    "model_mediated",
    "iss_damping",
    "energy_bounding",
    "four_channel_tdpa",
    "deadband_tdpa",
)
