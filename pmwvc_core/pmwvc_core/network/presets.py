# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Networks by name, and the timeline of a link, which may name them.

Networks are settings for both directions, as data, each with its source; "estimate" marks what is
not measured. Bursts of loss are Gilbert-Elliott, everything lost in the bad state.

A timeline goes from the first packet on: ``5 outage; 5.5 lte; 20 delay_s=0.02..0.2 loss=0.1; 30
base; 40 repeat``. Each entry holds until the next one. It names what differs from the settings of
the link: a network by name, single settings, a ramp of the delay; ``base``: nothing; ``outage``:
every packet is lost; ``repeat``, the last entry: it begins anew.
"""

import bisect
import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import Any

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import LinkParams, specs
from pmwvc_core.params.names import hint, timed


@dataclass(frozen=True)
class Preset:
    """Link settings from user to server (``up``) and back, and where the numbers come from."""

    up: LinkParams
    down: LinkParams
    basis: str


def _bursts(loss: float, length: float) -> dict[str, float]:
    """Return settings for a mean loss in bursts of a mean length [packets]."""
    return {"ge_p": loss / (length * (1.0 - loss)), "ge_r": 1.0 / length}


def _link(
    delay_s: float, jitter: str = "uniform", jitter_s: float = 0.0, **own: Any
) -> LinkParams:
    return LinkParams(delay_s=delay_s, jitter=jitter, jitter_s=jitter_s, keep_order=False, **own)


def _same(link: LinkParams, basis: str) -> Preset:
    return Preset(link, link, basis)


# Quantiles that the sources name, with points between them on a curve of their kind.
WIFI_GOOD = "0:0.0003 0.1:0.0008 0.25:0.0013 0.5:0.002 0.75:0.0032 0.9:0.0049 0.99:0.01 1:0.02"
WIFI_CAMPUS = "0:0.0003 0.25:0.0008 0.5:0.0015 0.75:0.004 0.9:0.01 0.95:0.03 0.99:0.125 1:0.3"
WIFI_BAD = "0:0.004 0.25:0.01 0.5:0.02 0.75:0.045 0.9:0.1 0.99:0.25 1:0.4"
_SLOTS: dict[str, Any] = {"slot_min_s": 2e-3, "slot_max_s": 20e-3}
_STARLINK = _link(
    25e-3, "normal", 5e-3, **_bursts(1e-2, 3.0), handover_s=15.0, handover_step_s=10e-3,
    handover_outage=0.3, handover_outage_min_s=0.05, handover_outage_max_s=0.3, handover_loss=0.3,
    handover_loss_s=0.5,
)  # fmt: skip
_TORTURE = _link(
    0.02, "pareto", 10e-3, jitter_shape=3.0, **_bursts(0.3, 10.0), duplicate=0.05, corrupt=1e-3,
    schedule="0 delay_s=0.02..0.38; 0.4 delay_s=0.38..0.02; 0.8 repeat",
)  # fmt: skip
PRESETS = {
    "ideal": _same(LinkParams(), "no network"),
    "lan": _same(
        _link(0.2e-3, "lognormal", 0.05e-3, jitter_shape=0.5, loss=1e-6),
        "wired part of a campus, 99 % below 1 ms (Sui et al. 2016); jitter and loss estimate",
    ),
    **{
        f"thesis_lan_{ms}": _same(LinkParams(delay_s=ms / 1e3), "dissertation: local network")
        for ms in (8, 16, 24)
    },
    "man_fibre": _same(
        _link(7e-3, "gamma", 0.7e-3, jitter_shape=2.0, **_bursts(1e-4, 1.5)),
        "fixed broadband, round trip 14 ms (Ookla 2021), loss below 0.4 % (FCC); jitter estimate",
    ),
    "continental": _same(
        _link(20e-3, "gamma", 2e-3, jitter_shape=2.0, **_bursts(1e-3, 2.0)),
        "loss below 0.1 % among developed regions (PingER); delay and jitter estimate",
    ),
    "transatlantic": _same(
        _link(45e-3, "gamma", 3e-3, jitter_shape=2.0, **_bursts(1e-3, 2.0)),
        "round trip 85 to 90 ms today, 120 ms in haptics US-UK 2007; jitter and loss estimate",
    ),
    "antipodal": _same(
        _link(140e-3, "gamma", 8e-3, jitter_shape=2.0, **_bursts(5e-3, 3.0)),
        "intercontinental haptics, round trip about 300 ms (Peer 2008); jitter and loss estimate",
    ),
    "wifi_good": _same(
        _link(1e-3, "quantiles", jitter_quantiles=WIFI_GOOD, **_bursts(1e-3, 2.0)),
        "802.11ax, 80 MHz: 99 % below 10 ms (measured), median 2 ms; ends and loss estimate",
    ),
    "wifi_campus": _same(
        _link(0.0, "quantiles", jitter_quantiles=WIFI_CAMPUS, **_bursts(5e-3, 3.0)),
        "half the round trip of 3, 20 and 250 ms at 50, 90 and 99 % (Sui 2016); the rest estimate",
    ),
    "wifi_bad": _same(
        _link(0.0, "quantiles", jitter_quantiles=WIFI_BAD, **_SLOTS, **_bursts(2e-2, 3.0)),
        "half of the packets above 20 ms, 10 % above 0.1 s (Pei 2016); slots, ends, loss estimate",
    ),
    "wifi_worst": _same(
        _link(0.0, "quantiles", jitter_quantiles=WIFI_BAD, **_SLOTS, **_bursts(5e-2, 6.0)),
        "wifi_bad with 5 % loss in bursts of 6; estimate",
    ),
    "5g_sa_campus": Preset(
        _link(11e-3, "uniform", 5e-3, **_bursts(5e-4, 4.0)),
        _link(7e-3, "uniform", 3e-3, **_bursts(5e-4, 4.0)),
        "stand-alone campus network, down 4 to 10 ms for 95 % (Rischke et al. 2021); up and "
        "loss estimate",
    ),
    "5g_nsa_public": Preset(
        _link(14e-3, "uniform", 4e-3, **_bursts(1e-3, 5.0)),
        _link(9.5e-3, "uniform", 2.5e-3, **_bursts(1e-3, 5.0)),
        "public network in Munich, below 7 ms down at best, 18 ms up at worst (drive test of "
        "Rohde & Schwarz); loss estimate",
    ),
    "lte": Preset(
        _link(25e-3, "uniform", 12e-3, slot_min_s=1e-3, slot_max_s=10e-3, **_bursts(1e-3, 5.0)),
        _link(15e-3, "uniform", 8e-3, slot_min_s=1e-3, slot_max_s=10e-3, **_bursts(1e-3, 5.0)),
        "estimate",
    ),
    "leo": _same(
        _STARLINK,
        "Starlink: round trip 50 ms in the median, reconfiguration every 15 s, up to 50 % loss "
        "around it (Michel et al. 2022, Mohan et al. 2023); probabilities and lengths estimate",
    ),
    "geo": _same(
        _link(300e-3, "normal", 10e-3, **_bursts(2e-3, 4.0)),
        "geostationary satellite: round trip about 600 ms, 477 at least (APNIC); loss estimate",
    ),
    "iss": _same(
        _link(425e-3, "uniform", 5e-3, **_bursts(1e-3, 10.0)),
        "relay satellites to low orbit; jitter and loss estimate",
    ),
    "lunar": _same(
        _link(1.28, "uniform", 5e-3, **_bursts(1e-3, 10.0)),
        "light to the Moon, one way; jitter and loss estimate",
    ),
    "torture": _same(_TORTURE, "no network: everything at once; delays change by 0.9 s a second"),
}


def link_settings(name: str, direction: str | None = None) -> dict[str, Any]:
    """Return a preset's parameters by dotted name (``link.up.delay_s``), of one way or both."""
    preset = PRESETS[name]
    return {
        f"link.{way}.{field}": getattr(getattr(preset, way), field)
        for way in ([direction] if direction else DIRECTIONS)
        for field in specs(LinkParams)
    }


DIRECTIONS = ("up", "down")
OWN_WORDS = ("base", "outage", "repeat")
NOT_HERE = ("schedule", "effects")


@dataclass(frozen=True)
class TimelineEntry:
    """One entry of a timeline."""

    start_s: float
    outage: bool = False
    preset: str = ""
    settings: tuple[tuple[str, Any], ...] = ()
    ramp_s: tuple[float, float] | None = None  # of the delay, until the next entry

    def applied(self, base: LinkParams, direction: int) -> LinkParams:
        """Return the settings of a link during this entry; direction 0 is up."""
        values = {name: getattr(base, name) for name in NOT_HERE}
        if self.preset:
            base = getattr(PRESETS[self.preset], DIRECTIONS[direction == 1])
        return dataclasses.replace(base, **values | dict(self.settings))


@dataclass(frozen=True)
class Timeline:
    """The entries in their order; the first begins at 0. After ``length_s`` it begins anew."""

    entries: tuple[TimelineEntry, ...]
    length_s: float = math.inf

    def at(self, elapsed_ns: int) -> tuple[int, float]:
        """Return which entry holds, and which part of its time has passed (0 without an end)."""
        time_s = elapsed_ns * 1e-9
        if self.length_s < math.inf:
            time_s %= self.length_s
        starts = [entry.start_s for entry in self.entries]
        number = bisect.bisect_right(starts, time_s) - 1
        start_s, end_s = (*starts, self.length_s)[number : number + 2]
        return number, (time_s - start_s) / (end_s - start_s) if end_s < math.inf else 0.0


@functools.lru_cache(maxsize=64)
def timeline_of(text: str) -> Timeline:
    """Read ``link.schedule``; ParameterError with the entry, its value and what it must be."""
    entries = [TimelineEntry(0.0)]
    length_s = math.inf
    for where, start_s, words in timed("schedule", text, "TIME SETTINGS", longest_s=1e6):
        if length_s < math.inf:
            raise ParameterError(f"{where}: nothing may come after repeat")
        if words == ["repeat"]:
            if not start_s:
                raise ParameterError(f"{where}: time = 0: must be > 0 s for repeat")
            length_s = start_s
        else:
            entry = _entry(where, start_s, words)
            entries = [entry] if start_s == 0.0 else [*entries, entry]
    if entries[-1].ramp_s and length_s == math.inf:
        raise ParameterError(f"schedule: {text!r}: a ramp needs a later entry, at which it ends")
    return Timeline(tuple(entries), length_s)


def _entry(where: str, start_s: float, words: list[str]) -> TimelineEntry:
    if words in (["outage"], ["base"]):
        return TimelineEntry(start_s, outage=words == ["outage"])
    preset, settings, ramp_s = "", {}, None
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            if name not in PRESETS or preset:
                near = hint(name, [*PRESETS, *OWN_WORDS])
                raise ParameterError(
                    f"{where}: {name!r}: must be one network by name, name=value, or only one of "
                    f"{', '.join(OWN_WORDS)}{near}"
                )
            if any(getattr(PRESETS[name], each).schedule for each in DIRECTIONS):
                raise ParameterError(f"{where}: {name!r} has a timeline itself: must be another")
            preset = name
        elif name == "delay_s" and ".." in value:
            first, last = (float(_setting(where, name, each)) for each in value.split("..", 1))
            ramp_s, settings["delay_s"] = (first, last), first
        else:
            settings[name] = _setting(where, name, value)
    return TimelineEntry(start_s, preset=preset, settings=tuple(settings.items()), ramp_s=ramp_s)


def _setting(where: str, name: str, text: str) -> Any:
    known = specs(LinkParams)
    if name not in known or name in NOT_HERE:
        raise ParameterError(f"{where}: {name!r}: there is no such setting{hint(name, known)}")
    spec = known[name]
    value = spec.converted(text)
    if problem := spec.problem(value):
        raise ParameterError(f"{where}: {name} = {problem}")
    return value
