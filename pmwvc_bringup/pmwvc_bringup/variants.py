# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers to compare by a word each: ``--controllers waves,ledger,filter_bank+position,tdpa``.

``pmwvc`` is the scenario's own settings with waves; ``waves`` is plain waves with nothing around
them; a feature stands for plain waves with it, and several may be joined by ``+``; the other
controllers stand for themselves.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.errors import ScenarioError
from pmwvc_core.simulation.scenario import CONTROLLERS

PLAIN: Mapping[str, str] = {
    "controller": "pmwvc",
    "server.compensation": "none",
    "master.velocity_filter.kind": "none",
    "master.bank.kind": "none",
    "master.position.feedback": "none",
}
FEATURES: Mapping[str, Mapping[str, str]] = {
    "waves": {},
    "printed": {"server.coupling": "unknown", "server.compensation": "printed"},
    "corrected": {"server.coupling": "unknown", "server.compensation": "corrected"},
    "ledger": {"server.coupling": "unknown", "server.compensation": "ledger"},
    "velocity_filter": {"master.velocity_filter.kind": "exact"},
    "velocity_filter_printed": {"master.velocity_filter.kind": "equivalent"},
    "filter_bank": {"master.bank.kind": "dissertation"},
    "complementary_bank": {"master.bank.kind": "complementary"},
    "position": {"master.position.feedback": "budgeted"},
    "position_printed": {"master.position.feedback": "printed"},
    "position_integral": {"master.position.feedback": "integral"},
}
DEFAULT_GAIN = "20"  # [sqrt(W)/m], App. E section 4, where the scenario has none


def names() -> list[str]:
    """Return every word that may stand in the list."""
    return [*CONTROLLERS, *FEATURES]


def settings_of(word: str, *, gain_given: bool) -> list[str]:
    """Return the settings ``name=value`` that a word stands for.

    Parameters
    ----------
    word
        A name, or features joined by ``+``.
    gain_given
        Whether the scenario has a gain of the position feedback itself.

    Raises
    ------
    ScenarioError
        Naming the words there are.
    """
    if word in CONTROLLERS:
        return [f"controller={word}"]
    found = dict(PLAIN)
    for part in word.split("+"):
        if part not in FEATURES:
            known = f"must be of {', '.join(names())}; features may be joined by +"
            raise ScenarioError("--controllers", [f"{part!r}: {known}"])
        found |= FEATURES[part]
        if part.startswith("position") and not gain_given:
            found["master.position.gain"] = DEFAULT_GAIN
    return [f"{name}={value}" for name, value in found.items()]


def words_of(text: str | None) -> Sequence[str]:
    """Return the words of a comma-separated list.

    Raises
    ------
    ScenarioError
        If a word is empty or given twice.
    """
    if text is None:
        return ()
    words = [word.strip() for word in text.split(",")]
    if not all(words) or len(set(words)) < len(words):
        raise ScenarioError("--controllers", [f"{text}: must be different names, a,b,..."])
    return words
