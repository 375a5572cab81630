# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The findings of passivity as text: every verdict with its amount and its tolerance."""

import numpy as np

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.parts import words_of
from pmwvc_analysis.budget.result import SERVER, Budget
from pmwvc_analysis.verdicts.passivity import Passivity
from pmwvc_core.quantities import quantity, share

PORTS = {
    "up": "link from the device to the server",
    "down": "link from the server to the device",
    "hand_port": "port of the hand",
    SERVER: "server with its environment",
}


def verdict(found: Passivity, owner: str) -> str:
    """Return the verdict of one user, or of the server, in one clause."""
    ports = found.of(owner)
    if not ports:
        return "passivity not judged"
    violated = [port for port in ports if port.passive is False]
    if violated:
        worst = min(violated, key=lambda port: port.least_j)
        return f"NOT passive: {part_words(worst)}, {amount(worst)}"
    unknown = [port for port in ports if port.passive is None]
    if unknown:
        why = unknown[0].why  # some texts begin with when
        return f"passivity {why if why.startswith('not judged') else f'not judged: {why}'}"
    least = min(ports, key=lambda port: port.least_j)
    if least.by_counts:
        bound = f"passive within the encoder's bound of {quantity(least.counts_j, 'J')}"
        return f"{bound}: {part_words(least)}, {amount(least)}"
    return "; ".join([f"passive: {amount(least)}", *(port.why for port in ports if port.why)])


def amount(finding: Finding) -> str:
    """Return least balance, its ratio, tolerance and declared storage; 0 J: it is rounding."""
    rounding = finding.passive and -finding.least_j <= finding.tolerance_j
    least = quantity(0.0 if rounding else finding.least_j, "J")
    text = f"least balance at server steps {least}"
    if finding.passive is False:
        text += f" at {finding.least_s:.2f} s" if finding.least_s is not None else ""
        text += f" ({_beside_moved(finding)})"
    text += f", tolerance {quantity(finding.tolerance_j, 'J')}"
    if finding.declared_j > 0.0:
        text += f", declared storage {quantity(finding.declared_j, 'J')}"
    return f"{text}; {finding.why}" if finding.held_j > 0.0 else text


def components(found: Passivity) -> list[str]:
    """Return the components that generated energy, each with its amount, worst first."""
    return [component(each, found) for each in found.components]


def component(finding: Finding, found: Passivity) -> str:
    """Return what one component generated, and whether the ports, which decide, show it."""
    where = "server" if finding.owner == SERVER else finding.owner
    text = (
        f"{where}: {words_of(finding.part)} generated {quantity(finding.given_j, 'J')} "
        f"({_beside_moved(finding)}) by {finding.least_s:.2f} s, "
        f"first at {finding.since_s:.2f} s; tolerance {quantity(finding.tolerance_j, 'J')}"
    )
    text += f"; {finding.why}" if finding.held_j > 0.0 else ""
    if not found.session:
        return text
    storage = any(each.declared_j > 0.0 for each in found.findings if each.decides)
    others = "other components or the declared storage" if storage else "other components"
    return f"{text}; the ports decide and all are passive: {others} covered it"


def _beside_moved(finding: Finding) -> str:
    """Return the energy given out as a ratio to the energy moved."""
    if not finding.moved_j > 0.0:
        return "no energy moved"
    return f"{share(finding.ratio)} {quantity(finding.moved_j, 'J')} moved"


def part_words(finding: Finding) -> str:
    """Return a port in words."""
    return PORTS.get(finding.part, finding.part.replace("_", " "))


def budget_lines(found: Budget, judged: Passivity) -> list[tuple[bool | None, str]]:
    """Return in words whether the budget closes and which components generated energy.

    Each line is good or bad; None where the ports, which decide, show that others paid for it.
    """
    residual = quantity(float(np.abs(found.residual_j).max()), "J")
    text = f"The energy budget closes to {residual}."
    if not found.closes:
        text = f"The energy budget does not close: {residual} are not explained."
    lines: list[tuple[bool | None, str]] = [(found.closes, text)]
    for part, hides in {each.part: each.hides for each in found.remainders}.items():
        words = words_of(part)
        lines.append((None, f"Remainder, not computed for itself: {words}. It hides {hides}."))
    for port in judged.findings:
        if port.decides and port.passive is False:
            lines.append((False, f"{port.owner}: {verdict(judged, port.owner)}."))
    paid = judged.session
    lines += [
        (None if paid else False, f"{component(each, judged)}.")
        for each in judged.components or found.active
    ]
    if not found.active and paid:
        limit = found.findings[0].tolerance_j
        lines.append((True, f"No component generated energy beyond {quantity(limit, 'J')}."))
    return lines
