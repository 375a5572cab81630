# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Link effects by name: the library, switched on by parameters of their own, and entry points of
the group ``pmwvc.link_effects``, by ``link.effects``: ``bursts:rate=0.02:stay=0.5
fading:depth=0.1``.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import product

from pmwvc_core.errors import ParameterError, PmwvcError, refusal
from pmwvc_core.network.effects.library import LIBRARY, ORDER
from pmwvc_core.network.effects.record import Effect, LinkEffect
from pmwvc_core.network.presets import timeline_of
from pmwvc_core.params import LinkParams
from pmwvc_core.plugins import Records, imported

__all__ = ["EFFECTS", "Effect", "LinkEffect"]
EFFECTS: Records[LinkEffect] = Records(
    LinkEffect, LIBRARY, group="pmwvc.link_effects", parameter="effects", what="a link effect"
)


def numbers_of(text: str) -> dict[str, dict[str, float]]:
    """Return the numbers of each plug-in in ``link.effects`` by name; else ParameterError."""
    found: dict[str, dict[str, float]] = {}
    for word in text.split():
        name, *pairs = word.split(":")
        try:
            values = {key: float(value) for key, value in (pair.split("=") for pair in pairs)}
        except ValueError:
            raise ParameterError(
                f"effects = {text!r}: {word!r} must be a name with its numbers, "
                "name:number=value:..."
            ) from None
        if name in found:
            raise ParameterError(f"effects = {text!r}: {name} is given twice")
        found[name] = values
    return found


@lru_cache(maxsize=256)
def plugins_of(text: str) -> tuple[LinkEffect, ...]:
    """Return the effects of other packages that a text names; else ParameterError."""
    found = []
    for name, values in numbers_of(text).items():
        record = imported(EFFECTS, name)
        if values.keys() != record.numbers.keys():
            raise ParameterError(
                f"effects = {text!r}: {name} takes {', '.join(record.numbers) or 'no numbers'}"
            )
        for key, spec in record.numbers.items():
            if wrong := spec.problem(values[key]):
                raise ParameterError(f"effects = {text!r}: {name}: {key} = {wrong}")
        found.append(record)
    return tuple(found)


def active(params: LinkParams) -> tuple[LinkEffect, ...]:
    """Return the effects that settings switch on, in their order."""
    own = [record for record in LIBRARY if record is not ORDER and record.active(params)]
    return (*own, *plugins_of(params.effects), ORDER)


def is_random(params: LinkParams) -> bool:
    """Tell whether the seed decides what a link does."""
    return any(record.random for record in active(params))


def longest_s(params: LinkParams) -> float:
    """Return the delay that tuning rules count [s]; NaN where an effect's part is not known."""
    spreads = [record.spread_s(params) for record in active(params)]
    return params.delay_s + sum(math.nan if each is None else each for each in spreads)


def mean_s(params: LinkParams) -> float:
    """Return the mean delay [s], without the effects whose part is not known."""
    return sum(record.mean_s(params) for record in active(params))


def amounts(params: LinkParams) -> dict[str, str]:
    """Return the effects beside the constant delay by name, in words with their amounts."""
    texts = {record.name: record.amount(params) for record in active(params)}
    for record in plugins_of(params.effects):
        texts[record.name] = texts[record.name] or f"link effect {record.name}"
    return {name: text for name, text in texts.items() if text}


def conflicts(params: LinkParams) -> Iterator[str]:
    """Yield what is wrong between settings that are each right, then in the timeline."""
    if wrong := refusal(active, params):
        yield wrong
        return
    yield from filter(None, (record.conflict(params) for record in active(params)))
    if not params.schedule or refusal(timeline_of, params.schedule):
        return  # which tells that itself
    for entry, direction in product(timeline_of(params.schedule).entries, (0, 1)):
        try:
            check(replace(entry.applied(params, direction), schedule=""))
        except PmwvcError as error:
            yield f"schedule: entry at {entry.start_s:g} s: {error}"
            return


def check(params: LinkParams) -> None:
    """Raise a PmwvcError for a file or parameter that cannot be used, naming it."""
    for record in active(params):
        record.check(params)
    for text in conflicts(params):
        raise ParameterError(text)
