# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance between avatar and device that joining may leave, in words."""

LEAST_M = 1e-3  # avatars less far from their device are not reported


def why_kept(*, waves: bool, black_box: bool) -> str:
    """Return why a distance at joining stays, for a controller and an environment."""
    if not waves:
        return "this controller keeps the distance"
    if black_box:
        return "an environment known by its forces only has no face to stop at, so it cannot slide"
    return "it joined with the device inside the object, and slides to it once there is room"


def kept_words(distance_m: float, why: str) -> str:
    """Return the distance and why it stays; nothing below ``LEAST_M``."""
    if not distance_m > LEAST_M:
        return ""
    return f"avatar {1e3 * distance_m:.1f} mm from the device since joining: {why}"
