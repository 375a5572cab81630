# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conclusion of a comparison in plain sentences, each from a number of its table.

One paragraph per condition: sessions that differ in the controller alone are compared with each
other. Without controllers to compare, all sessions make one paragraph.
"""

import math
from collections.abc import Callable, Mapping, Sequence

from pmwvc_analysis.compare.measures import Compared
from pmwvc_core.network.effects import amounts
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import listed, quantity

CONTROLLER = "controller"
ALIKE = 0.02  # relative difference below which stiffnesses and masses count as the same
MOST_NAMED = 8


def conclusion(entries: Sequence[Compared]) -> list[str]:
    """Return one paragraph per condition, the conditions of all first."""
    if len(entries) < 2:
        return []
    groups: dict[str, list[Compared]] = {}
    for entry in entries:
        of = entry.settings if CONTROLLER in entry.settings else {}
        heading = ", ".join(f"{name} = {v}" for name, v in of.items() if name != CONTROLLER)
        groups.setdefault(heading, []).append(entry)
    paragraphs = [_conditions(entries)]
    for heading, group in groups.items():
        stable = [entry for entry in group if entry.measures["stable"]]
        found = [_unstable(group), *_stiffest(stable), _free(stable), _passive(group)]
        text = " ".join(sentence for sentence in found if sentence)
        paragraphs.append(f"With {heading}: {text}" if heading else text)
    return paragraphs


def _conditions(entries: Sequence[Compared]) -> str:
    first = entries[0].scenario

    def contact(of: Scenario) -> str:
        own = of.users[0].contact
        return f"{own.contact_stiffness:g} N/m with {own.contact_damping:g} N s/m"

    source = "Live" if entries[0].traces.live else "Simulated"
    return (
        f"{source} sessions of {_over(entries, lambda of: f'{of.duration_s:g} s')}, "
        f"{_over(entries, _delay)}, contact {_over(entries, contact)}; one set of hands and "
        "packet fates. Stiffness, mass and damping are those rendered to "
        f"{first.users[0].name}. Another task, hand or delay may order the controllers "
        "differently."
    )


def _over(entries: Sequence[Compared], text: Callable[[Scenario], str]) -> str:
    return _joined(dict.fromkeys(text(entry.scenario) for entry in entries), "or")


def _delay(of: Scenario) -> str:
    first = of.users[0]
    up, down = 1e3 * first.link_up.delay_s, 1e3 * first.link_down.delay_s
    delay = f"{up:g} ms each way" if up == down else f"{up:g} ms up and {down:g} ms down"
    effects = (*amounts(first.link_up).values(), *amounts(first.link_down).values())
    return ", ".join([f"delay {delay}", *dict.fromkeys(effects)])


def _unstable(group: Sequence[Compared]) -> str:
    judged = [(entry, entry.measures["stable"]) for entry in group]
    bad = [f"{_name(e)} ({e.measures['instability']})" for e, ok in judged if ok is False]
    named = {"Not stable": bad, "Not judged": [_name(e) for e, ok in judged if ok is None]}
    return _listed(named) or "All sessions were stable."


def _stiffest(stable: Sequence[Compared]) -> list[str]:
    known = sorted(_with(stable, "k_felt"), key=lambda entry: -entry.measures["k_felt"])
    if not known:
        return ["No stiffness at rest is known."] if stable else []
    best, last = known[0], known[-1]
    nearly = (1.0 - ALIKE) * best.measures["k_felt"]
    tied = [_name(entry) for entry in known if entry.measures["k_felt"] >= nearly]
    renders = "renders" if len(tied) == 1 else "render"
    softest = f"; {_name(last)} the softest, {_stiffness(last)}" if len(tied) < len(known) else ""
    found = [f"{_joined(tied)} {renders} the stiffest contact, {_stiffness(best)}{softest}."]
    passive = [entry for entry in known if entry.measures["passive"]]
    if passive and passive[0] is not best and not best.measures["passive"]:
        named = f"{_name(passive[0])}, {_stiffness(passive[0])}"
        found.append(f"The stiffest that stayed passive is {named}.")
    if unknown := [_name(entry) for entry in stable if entry not in known]:
        why = "does not settle, or not to the same place"
        found.append(f"Unknown at rest ({why}): {_joined(unknown)}.")
    return found


def _free(stable: Sequence[Compared]) -> str:
    ranked = []  # by force per velocity of the swing [N s/m]
    for entry in _with(stable, "mass_free_kg"):
        found = entry.measures
        mass_kg, damping = float(found["mass_free_kg"]), float(found["damping_free_n_s_m"])
        effort = math.hypot(2.0 * math.pi * float(found["free_hz"]) * mass_kg, damping)
        ranked.append((effort, f"{_name(entry)} ({mass_kg:.3g} kg and {damping:.2g} N s/m)"))
    ranked.sort(key=lambda each: each[0])
    if len(ranked) < 2:
        return ""
    least, most = ranked[0][1], ranked[-1][1]
    return f"In free space {least} takes the least force to move, {most} the most."


def _passive(group: Sequence[Compared]) -> str:
    active = [
        f"{_name(e)} ({e.measures['active_part']}, {quantity(e.measures['energy_min_j'], 'J')})"
        for e in group
        if e.measures["passive"] is False
    ]
    named = {
        "Passive at every port": [_name(e) for e in group if e.measures["passive"]],
        "Not passive, with port and least balance": active,
        "Passivity not judged": [_name(e) for e in group if e.measures["passive"] is None],
    }
    return _listed(named)


def _listed(groups: Mapping[str, Sequence[str]]) -> str:
    """Return a sentence for each group that has members."""
    return " ".join(f"{words}: {_joined(named)}." for words, named in groups.items() if named)


def _with(entries: Sequence[Compared], measure: str) -> list[Compared]:
    """Return the sessions of which a measure is known."""
    return [entry for entry in entries if entry.measures[measure] is not None]


def _stiffness(entry: Compared) -> str:
    contact = float(entry.scenario.users[0].contact.contact_stiffness)
    stiffness = float(entry.measures["k_felt"])
    return f"{stiffness:.4g} N/m ({100.0 * stiffness / contact:.0f} % of the contact's)"


def _name(entry: Compared) -> str:
    return str(entry.settings.get(CONTROLLER, entry.label))


def _joined(words: Sequence[str] | dict[str, None], last: str = "and") -> str:
    names = list(words)
    if len(names) > MOST_NAMED:
        names = [*names[: MOST_NAMED - 1], f"{len(names) - MOST_NAMED + 1} more"]
    return listed(names, last)
