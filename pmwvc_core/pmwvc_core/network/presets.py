# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Networks by name, and the timeline of a link, which may name them.

The networks stand in ``presets.yaml`` beside this file, each with the source of its numbers.

A timeline goes from the first packet on: ``5 outage; 5.5 lte; 20 delay_s=0.02..0.2 loss=0.1; 30
base; 40 repeat``. Each entry holds until the next one. It names what differs from the settings of
the link: a network by name, single settings, a ramp of the delay; ``base``: nothing; ``outage``:
every packet is lost; ``repeat``, the last entry: it begins anew.
"""

import bisect
import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import LinkParams, specs
from pmwvc_core.params.names import hint, timed


@dataclass(frozen=True)
class Preset:
    """Link settings from user to server (``up``) and back, and where the numbers come from."""

    up: LinkParams
    down: LinkParams
    basis: str


def _preset(basis: str, **links: Mapping[str, Any]) -> Preset:
    up, down = (_link(**links.get("both") or links[way]) for way in DIRECTIONS)
    return Preset(up, down, basis)


def _link(keep_order: bool = False, bursts: Sequence[float] = (), **settings: Any) -> LinkParams:
    if bursts:
        loss, length = bursts
        settings |= {"ge_p": loss / (length * (1.0 - loss)), "ge_r": 1.0 / length}
    return LinkParams(keep_order=keep_order, **settings)


DIRECTIONS = ("up", "down")
_FILE = Path(__file__).with_name("presets.yaml").read_text("utf-8")
PRESETS = {name: _preset(**each) for name, each in yaml.safe_load(_FILE).items()}


def link_settings(name: str, direction: str | None = None) -> dict[str, Any]:
    """Return a preset's parameters by dotted name (``link.up.delay_s``), of one way or both."""
    preset = PRESETS[name]
    return {
        f"link.{way}.{field}": getattr(getattr(preset, way), field)
        for way in ([direction] if direction else DIRECTIONS)
        for field in specs(LinkParams)
    }


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
