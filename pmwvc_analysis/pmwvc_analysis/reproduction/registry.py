# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""All figures of the reproduction by name, and those that wait for their controller."""

from pmwvc_analysis.reproduction import (
    appendix_a,
    appendix_b,
    appendix_c,
    appendix_d,
    appendix_e,
)
from pmwvc_analysis.reproduction.figure import Figure

FIGURES: dict[str, Figure] = {
    figure.name: figure
    for appendix in (appendix_a, appendix_b, appendix_c, appendix_d, appendix_e)
    for figure in appendix.FIGURES
}
# Figures that show a controller which is not here yet: they come with it.
WITH_THEIR_CONTROLLER = {
    "E5": "stability region with filter bank and local model",
    "E6 to E8": "admittance and impedance with filter bank and local model",
}
