# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The findings on passivity of one session (criterion: :mod:`..budget.criterion`), and in words.

Ports decide the verdict:

=============  ================================================================================
``up``         of a user: from the wave of its device to that at the server (energy.py)
``down``       and back
``hand_port``  what the force applied did on the way of the device, less what the server got
``server``     of the server: what it and its environment took in at the ports of all users
=============  ================================================================================

Parts of the energy budget are components between these ports. Where a port is not passive, those
of its owner that released energy are named with their amount.
"""

from dataclasses import dataclass, replace

import numpy as np

from pmwvc_analysis.budget import energy
from pmwvc_analysis.budget.criterion import Balance, Finding, together
from pmwvc_analysis.budget.result import SERVER, Budget
from pmwvc_analysis.traces.holes import Kind, Unjudged, of_server, skips, starts
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.server.couplings import COMPENSATIONS
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.words import quantity, share

NO_SERVER = "the server's trace is missing"
NO_SCENARIO = "without the scenario its declared storage is not known"


@dataclass(frozen=True)
class Passivity:
    """All ports of a session, the components that may be why one is not passive, and the energies
    that the ports of users were found in.
    """

    ports: tuple[Finding, ...]
    components: tuple[Finding, ...] = ()
    users: tuple[energy.UserEnergy, ...] = ()

    def of(self, owner: str) -> list[Finding]:
        """Return the ports of one owner."""
        return [each for each in self.ports if each.owner == owner]

    def passive(self, owner: str) -> bool | None:
        """Return the verdict of one user, or of the server."""
        return together(each.passive for each in self.of(owner))

    @property
    def session(self) -> bool | None:
        """Return the verdict of the session: of all ports."""
        return together(each.passive for each in self.ports)


def passivity(
    traces: SessionTraces, scenario: Scenario | None, energies: Budget | None
) -> Passivity:
    """Judge every port of a session; name the components of those that are not passive."""
    balances = {entry.name: entry for entry in energy.user_energies(traces, scenario)}
    ports: list[Finding] = []
    for user in traces.users:
        if (entry := balances.get(user.name)) is None:
            ports.append(Finding(user.name, "hand_port", None, why=NO_SERVER))
            continue
        clock = traces.metadata.get("alignment", {}).get(user.name, {})
        open_s = float(clock.get("uncertainty_s", 0.0))
        for part, balance in entry.parts.items():
            port, why = _held(balance.judged(user.name, part, entry.unjudged), user), ""
            if port.passive is False and open_s > 0.0:
                why = energy.clocks_explain(part, balance, open_s)
            ports.append(_excused(port, why if scenario else NO_SCENARIO))
    if traces.server is not None and len(traces.server.time_s):
        ports.append(_of_server(traces.server, scenario))
    violated = {port.owner for port in ports if port.passive is False}
    released = energies.released if violated and energies else []
    components = tuple(each for each in released if each.owner in violated)
    return Passivity(tuple(ports), components, tuple(balances.values()))


def _held(found: Finding, user: UserTraces) -> Finding:
    """Return a violation with what the last force gave to the hand while the loop stood still."""
    rows = skips(user)
    moved = user.x_m[rows + 1] - user.x_m[rows]
    gave_j = np.maximum(-np.sum(user.f_applied[rows] * moved, axis=-1), 0.0)
    gave_j = gave_j[user.time_s[rows] <= (found.least_s or 0.0)]
    held_j = min(float(gave_j.sum()), found.given_j - found.declared_j - found.counts_j)
    if found.passive is not False or found.part != "hand_port" or held_j <= found.tolerance_j:
        return found
    why = f"{quantity(held_j, 'J')} of it gave the force that stayed on while its loop stood still"
    return replace(found, held_j=held_j, why=why)


def _of_server(server: ServerTraces, scenario: Scenario | None) -> Finding:
    taken, given, _ = energy.server_sums(server)
    rows, unknown = slice(None), of_server(server)
    for row in starts(server)[:1]:  # what it held died with it
        rows, (since_s, until_s) = slice(row), server.time_s[[row, -1]].tolist()
        unknown.append(Unjudged(since_s, until_s, SERVER, Kind.RESTART))
    allowance_j = 0.0  # of a port ledger
    if scenario is not None and scenario.coupling.black_box:
        compensation = COMPENSATIONS.of(scenario.server.compensation)
        allowance_j = compensation.allowance_j(scenario.server)
    balance = Balance(server.time_s[rows], taken[rows], given[rows], allowance_j)
    found = balance.judged(SERVER, SERVER, unknown)
    if scenario is None:
        return _excused(found, "without the scenario its environment is not known")
    return _excused(found, scenario.environment.own_energy(scenario.server))


def _excused(found: Finding, why: str) -> Finding:
    """Return a finding as not judged where something unknown may explain what was given out."""
    if found.passive is not False or not why:
        return found
    return replace(found, passive=None, why=f"it gave out {quantity(found.given_j, 'J')}; {why}")


def verdict(found: Passivity, owner: str) -> str:
    """Return the verdict of one user, or of the server, in one clause."""
    if not (ports := found.of(owner)):
        return "passivity not judged"
    violated = [port for port in ports if port.passive is False]
    if violated:
        worst = min(violated, key=lambda port: port.least_j)
        return f"NOT passive: {worst.words}, {amount(worst)}"
    for port in ports:
        if port.passive is None:
            return f"passivity not judged: {port.why}"
    least = min(ports, key=lambda port: (port.least_j, -port.declared_j))
    text = f"{least.words}, " * (least.least_j < -least.tolerance_j) + amount(least)
    if least.least_j < -least.declared_j - least.tolerance_j:  # counts of an encoder explain it
        return f"passive within the encoder's bound of {quantity(least.counts_j, 'J')}: {text}"
    return f"passive: {text}"


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


def component(finding: Finding) -> str:
    """Return what one component generated."""
    where = "server" if finding.owner == SERVER else finding.owner
    return (
        f"{where}: {finding.words} generated {quantity(finding.given_j, 'J')} "
        f"({_beside_moved(finding)}) by {finding.least_s:.2f} s, "
        f"first at {finding.since_s:.2f} s; tolerance {quantity(finding.tolerance_j, 'J')}"
    )


def _beside_moved(finding: Finding) -> str:
    """Return the energy given out as a ratio to the energy moved."""
    return f"{share(finding.given_j / finding.moved_j)} {quantity(finding.moved_j, 'J')} moved"
