# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The title of a figure, and the line of parameters below it."""

from collections.abc import Container

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.network.effects import active
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario


def title(text: str, scenario: Scenario | None) -> str:
    """Return a figure's title: its subject and the scenario."""
    return f"{text} · {scenario.name}" if scenario else text


def conditions(scenario: Scenario, source: str, *, without: Container[str] = ()) -> str:
    """Return the parameters of a scenario in a line, of the first user where users differ.

    The line begins with the source of the figure's numbers; parameters that are varied in it or
    have no effect on it are ``without``.
    """
    user = scenario.users[0]
    parts = [
        ("", source),
        ("", count(len(scenario.users), "user")),
        ("", f"controller {scenario.controller}"),
    ]
    if has_waves(scenario.controller):
        parts += [
            ("impedance", f"b = {user.impedance:.4g} N s/m"),
            ("rate_drop", f"M = {user.master.rate_drop}"),
        ]
        if scenario.strict:
            parts.append(("channel", f"channel {scenario.channel}"))
        else:
            parts += [
                ("filter", f"filter {user.master.filter.kind.replace('_', ' ')}"),
                ("hold", f"hold {user.master.hold}"),
            ]
        parts += [("coupling", f"coupling {scenario.server.coupling.replace('_', ' ')}")]
    delays = [f"{u.link_up.delay_s * 1e3:g}/{u.link_down.delay_s * 1e3:g}" for u in scenario.users]
    jitters = dict.fromkeys(
        effect.label(link)
        for one in scenario.users
        for link in (one.link_up, one.link_down)
        for effect in active(link)
        if effect.spreads
    )
    parts += [
        ("contact_stiffness", f"K = {user.contact.contact_stiffness:g} N/m"),
        ("contact_damping", f"B = {user.contact.contact_damping:g} N s/m"),
        ("delay_s", ", ".join([f"delay {', '.join(dict.fromkeys(delays))} ms", *jitters])),
        ("seed", f"seed {scenario.seed}"),
    ]
    return " · ".join(text for name, text in parts if name not in without)
