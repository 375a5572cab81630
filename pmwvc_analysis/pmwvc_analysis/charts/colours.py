# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of all figures, by name: one set for light paper, one for dark screens.

The eight user colours stay apart by at least 25 (CIE 1976 L*a*b* distance) for normal sight,
protanopia and deuteranopia, also from the object's colour.
"""

from collections.abc import Mapping

LIGHT_USERS = (
    "#1768B6", "#B15300", "#34B173", "#A15C85", "#5BAEE0", "#F19000", "#520E5F", "#4F2D00",
)  # fmt: skip
DARK_USERS = (
    "#14A0FB", "#F07D02", "#7BDD95", "#C18A9E", "#6DCFFF", "#FFE770", "#9B64A5", "#9C6F36",
)  # fmt: skip
LIGHT: Mapping[str, str] = {
    **{f"u{index}": tint for index, tint in enumerate(LIGHT_USERS)},
    "object": "#222222",
    "target": "#7F7F7F",
    "hand": "#A9ADB2",
    "alarm": "#B00020",
    "paper": "#FFFFFF",
    "ink": "#1C1F23",
    "soft": "#5B636D",
    "grid": "#E3E6EA",
}
DARK: Mapping[str, str] = {
    **{f"u{index}": tint for index, tint in enumerate(DARK_USERS)},
    "object": "#E8EAED",
    "target": "#9AA3AD",
    "hand": "#717A84",
    "alarm": "#FF6B7A",
    "paper": "#14171B",
    "ink": "#E6E8EB",
    "soft": "#A3ABB4",
    "grid": "#2B3138",
}


def user_tint(index: int) -> str:
    """Return the name of a user's colour."""
    return f"u{index % len(LIGHT_USERS)}"


def css_variables(colours: Mapping[str, str]) -> str:
    """Return the colours as CSS custom properties ``--c-NAME``."""
    return " ".join(f"--c-{name}: {tint};" for name, tint in colours.items())
