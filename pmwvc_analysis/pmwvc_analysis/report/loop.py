# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A drawing of one user's loop as SVG: blocks with their parameters and the energy that each took
in by the end (negative: generated), signals between them.
"""

from collections.abc import Mapping
from typing import NamedTuple

from pmwvc_analysis.budget.result import SERVER, Budget
from pmwvc_analysis.report.page import filled
from pmwvc_core.controllers.library import has_waves, proofs_hold
from pmwvc_core.network.effects import active
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.filter_design import pole_of
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.words import quantity

PARTS: Mapping[str, tuple[str, ...]] = {
    "device": ("device_kinetic", "device_damping", "sample_hold", "safety"),
    "filter": ("filter", "rate_drop", "filter_and_hold"),
    "hold": ("hold",),
    "up": ("link_up", "link"),
    "down": ("link_down",),
    "decoder": ("late_decoding", "integration", "withheld", "contained", "avatar_brakes"),
    "contact": ("contact_damping", "contact_stored", "environment_stored", "environment_heat"),
    "object": ("object_kinetic", "object_damping"),
}
ALL_USERS = ("decoder", "contact", "object")
SMALL_J = 5e-9  # shown as zero


class LoopBlock(NamedTuple):
    """One block: its title, its numbers, and the energy it took in [J] (None: not known)."""

    title: str
    lines: list[str]
    energy_j: float | None = None


def blocks(scenario: Scenario, user: User, energies: Budget | None) -> dict[str, LoopBlock]:
    """Return the blocks of one user's loop by name."""
    master, server, contact, device = user.master, scenario.server, user.contact, user.device
    operator, waves = user.operator, has_waves(scenario.controller)
    hand = operator.kind.replace("_", " ")
    if operator.is_hand or operator.is_remote:
        mass = operator.mass if operator.is_hand else operator.remote.mass
        hand = f"{'' if operator.is_hand else 'remote, '}arm {_number(mass)} kg"
    port = [_hertz(1.0 / master.tick_s)]
    decoder = [_hertz(1.0 / server.period_s), server.coupling.replace("_", " ")]
    if waves:
        switches = (
            (f"velocity filter: {master.velocity_filter.kind}", master.velocity_filter.is_on),
            (f"local model: {master.bank.kind}", master.bank.is_on),
            (f"position: {master.position.feedback}", master.position.is_on),
        )
        port = [*_impedance(user.impedance), *port, *(text for text, on in switches if on)]
        decoder = [*_impedance(user.server_impedance), *decoder]
    title = "wave port" if proofs_hold(scenario.controller) else scenario.controller
    rate = f"1 of {master.rate_drop}, {_hertz(1.0 / (master.tick_s * master.rate_drop))}"
    sender = ("rate drop", [rate])
    hold = ("hold", [{"zoh": "zero order", "foh": "first order"}[master.hold]])
    if scenario.strict:
        felt = [f"deadband {master.deadband.ratio:.0%}"] if master.deadband.is_on else []
        sender = ("sender", ["integral and energy", rate, *felt])
        hold = ("playout", ["every tick"])
    elif waves:
        words = master.filter.kind.replace("_", " ")
        if master.filter.kind == "first_order":
            words += f", {_number(float(pole_of(master.filter)))} rad/s"
        sender = ("filter, rate drop", [words, rate])
    limits = f"limits: {_number(user.given_safety.max_force)} N"
    stiffness = f"K = {_number(contact.contact_stiffness)} N/m"
    touches = [stiffness, f"B = {_number(contact.contact_damping)} N s/m"]
    object_mass = [f"{_number(server.object_mass)} kg"] if scenario.environment.movable else []
    texts = {
        "hand": ("hand", [hand]),
        "device": ("device and limits", [f"{_number(device.mass)} kg", limits]),
        "port": (title.replace("_", " "), port),
        "filter": sender,
        "hold": hold,
        "up": ("link up", _link(user.link_up)),
        "down": ("link down", _link(user.link_down)),
        "decoder": ("server port", decoder),
        "contact": ("contact", touches if scenario.environment.contact_law else []),
        "object": (server.environment.replace("_", " "), object_mass),
    }
    taken = _energies(user.name, energies)
    return {name: LoopBlock(*text, taken.get(name)) for name, text in texts.items()}


def _link(link: LinkParams) -> list[str]:
    texts = [(each.spreads, each.brief(link)) for each in active(link) if each.brief(link)]
    times = [f"{link.delay_s * 1e3:.4g} ms", *(text for spreads, text in texts if spreads)]
    return [", ".join(times), *(text for spreads, text in texts if not spreads)]


def _energies(name: str, energies: Budget | None) -> dict[str, float]:
    if energies is None or name not in energies.hands:
        return {}
    own = energies.parts[name]
    last = {part: float(sums[-1]) for part, sums in (own | energies.parts[SERVER]).items()}
    found = {"hand": float(energies.hands[name][-1])}
    for block, parts in PARTS.items():
        if any(part in last for part in parts):
            found[block] = sum(last[part] for part in parts if part in last)
    rest = [part for part in own if part not in {each for of in PARTS.values() for each in of}]
    if rest:
        found["port"] = sum(last[part] for part in rest)
    return found


def _impedance(impedance: Impedance) -> list[str]:
    """Return an impedance, a row of a matrix in each line."""
    return f"b = {impedance:.4g} N s/m".replace("; ", ";\n").splitlines()


def _hertz(value: float) -> str:
    return f"{value / 1e3:.4g} kHz" if value >= 999.5 else f"{value:.4g} Hz"


def _number(value: float) -> str:
    return f"{float(value):.4g}"


def drawing(found: Mapping[str, LoopBlock], *, name: str, waves: bool) -> str:
    """Return the drawing of one user's loop."""
    rows = {key: _rows(block, shared=key in ALL_USERS) for key, block in found.items()}
    return filled("loop.svg.j2", blocks=rows, name=name, waves=waves)


def _rows(block: LoopBlock, *, shared: bool) -> list[tuple[str, str]]:
    """Return the lines of a block, each with its kind of text."""
    rows = [(block.title, "loop-title"), *((line, "") for line in block.lines)]
    if block.energy_j is not None:
        energy = 0.0 if abs(block.energy_j) < SMALL_J else block.energy_j
        gives = block.title == "hand"
        text = f"{'gives' if gives else 'E ='} {quantity(energy, 'J').replace('-', '−')}"
        rows.append((text, "loop-alarm" if energy < 0.0 and not gives else "loop-energy"))
        rows += [("of all users", "loop-soft")] if shared else []
    return rows
