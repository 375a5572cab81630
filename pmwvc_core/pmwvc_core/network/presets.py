# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Networks by name: link settings for both directions, as data.

A preset is plausible, not universal. It holds mean and spread of the delay and the mean loss; what
a link cannot express is left out and named: loss comes one packet at a time where real loss comes
in bursts, and a long tail becomes a symmetric spread. Networks that are mostly tail or outage
(busy Wi-Fi, satellites that change hands) have no preset: use ``jitter: trace`` with a recording.
"""

from dataclasses import dataclass
from typing import Any

from pmwvc_core.params import LinkParams, specs


@dataclass(frozen=True)
class Preset:
    """Link settings from user to server (``up``) and back, and where the numbers come from."""

    up: LinkParams
    down: LinkParams
    basis: str


def _constant(delay_s: float) -> LinkParams:
    return LinkParams(delay_s=delay_s)


def _normal(delay_s: float, deviation_s: float, loss: float) -> LinkParams:
    return LinkParams(delay_s=delay_s, jitter="normal", jitter_s=deviation_s, loss=loss)


def _uniform(delay_s: float, half_width_s: float, loss: float) -> LinkParams:
    return LinkParams(delay_s=delay_s, jitter="uniform", jitter_s=half_width_s, loss=loss)


def _same(link: LinkParams, basis: str) -> Preset:
    return Preset(link, link, basis)


# A gamma distribution of shape 2 and mean m has the deviation m / sqrt(2); a log-normal one of
# median m and sigma s the mean m exp(s^2/2) and the deviation mean * sqrt(exp(s^2) - 1).
PRESETS = {
    "ideal": _same(LinkParams(), "no network"),
    "lan": _same(
        _normal(257e-6, 30e-6, 1e-6),
        "wired campus, 99 % below 1 ms; 0.2 ms and log-normal (0.05 ms, 0.5); estimate",
    ),
    "thesis_lan_8": _same(_constant(0.008), "dissertation: local network, 8 ms each way"),
    "thesis_lan_16": _same(_constant(0.016), "dissertation: local network, 16 ms each way"),
    "thesis_lan_24": _same(_constant(0.024), "dissertation: local network, 24 ms each way"),
    "man_fibre": _same(
        _normal(7.7e-3, 0.49e-3, 1e-4),
        "fixed broadband, round trip 14 ms in the median; 7 ms and gamma (2, 0.7 ms)",
    ),
    "continental": _same(
        _normal(22e-3, 1.4e-3, 1e-3), "loss below 0.1 % among developed regions; gamma (2, 2 ms)"
    ),
    "transatlantic": _same(
        _normal(48e-3, 2.1e-3, 1e-3), "round trip 85 to 90 ms and gamma (2, 3 ms)"
    ),
    "antipodal": _same(
        _normal(148e-3, 5.7e-3, 5e-3),
        "intercontinental haptics, round trip about 300 ms; gamma (2, 8 ms)",
    ),
    "wifi_good": _same(
        _normal(3.5e-3, 2.0e-3, 1e-3),
        "802.11ax: 1 ms and 2 ms in the median, 99 % below 10 ms; moments of that log-normal",
    ),
    "5g_sa_campus": Preset(
        _uniform(11e-3, 5e-3, 5e-4),
        _uniform(7e-3, 3e-3, 5e-4),
        "stand-alone campus network: range of 95 % of the packets; loss estimated",
    ),
    "5g_nsa_public": Preset(
        _uniform(14e-3, 4e-3, 1e-3),
        _uniform(9.5e-3, 2.5e-3, 1e-3),
        "public network, drive test; loss estimated",
    ),
    "lte": Preset(_uniform(25e-3, 12e-3, 1e-3), _uniform(15e-3, 8e-3, 1e-3), "estimate"),
    "geo": _same(_normal(300e-3, 10e-3, 2e-3), "geostationary satellite: round trip about 600 ms"),
    "iss": _same(_uniform(425e-3, 5e-3, 1e-3), "relay satellites to low orbit"),
    "lunar": _same(_uniform(1.28, 5e-3, 1e-3), "light to the Moon, one way"),
}


def link_settings(name: str, directions: tuple[str, ...] = ("up", "down")) -> dict[str, Any]:
    """Return the link parameters that a preset stands for, by dotted name (``link.up.delay_s``).

    Raises
    ------
    KeyError
        If there is no such preset.
    """
    preset = PRESETS[name]
    return {
        f"link.{direction}.{field}": getattr(getattr(preset, direction), field)
        for direction in directions
        for field in specs(LinkParams)
    }
