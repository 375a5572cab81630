# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""All figures of the reproduction by name."""

from reproduction import (
    appendix_a,
    appendix_b,
    appendix_c,
    appendix_d,
    appendix_e,
    position_drift,
)
from reproduction.figure import Figure

FIGURES: dict[str, Figure] = {
    figure.name: figure
    for appendix in (appendix_a, appendix_b, appendix_c, appendix_d, appendix_e, position_drift)
    for figure in appendix.FIGURES
}
