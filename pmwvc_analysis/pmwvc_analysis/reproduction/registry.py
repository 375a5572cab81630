# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""All figures of the reproduction, by name."""

from pmwvc_analysis.reproduction import appendix_a, appendix_b
from pmwvc_analysis.reproduction.figure import Figure

FIGURES: dict[str, Figure] = {
    figure.name: figure for figure in (*appendix_a.FIGURES, *appendix_b.FIGURES)
}
