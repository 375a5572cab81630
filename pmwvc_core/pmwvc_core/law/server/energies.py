# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is stored at the server, what else an environment counts, what is seen of its ports."""

from typing import NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.safety.brakes import AvatarBrake
from pmwvc_core.law.server.body import kinetic_j
from pmwvc_core.law.server.contacts import contact_energy, touching
from pmwvc_core.law.server.server_port import Environment, EnvironmentParams, UserPort
from pmwvc_core.law.vectors import Vector

# (p, s) -> energies [J]: kinetic, potential, and the accounts of the environment
environment_energies = Family("environment_energies")
port_shown = Family("port_shown")  # (p, s, user) -> PortShown
brake_j = Family("brake_j")  # (brake) -> heat since the start [J]


class PortShown(NamedTuple):
    """A user's port as seen from outside."""

    v_s: Vector  # [sqrt(W)] zero without waves
    touches: bool
    learned: float  # (K T + 2B)/b of what its avatar touches; zero where it learns nothing


@brake_j.member(AvatarBrake)
def _heat_j(s: AvatarBrake) -> float:
    return s.heat_j


def brakes_j(ports: tuple[UserPort, ...]) -> float:
    """Return the heat of all avatars' brakes since the start [J]."""
    total = 0.0
    for i in range(len(ports)):
        total += brake_j(ports[i].brake)
    return total


def potential_j(s: Environment) -> float:
    """Return the energy of all contact springs [J]."""
    total = 0.0
    for i in range(len(s.ports)):
        if s.ports[i].avatar.present:
            total += contact_energy(s.ports[i].avatar.contact)
    return total


@environment_energies.member(EnvironmentParams)
def _energies(p: EnvironmentParams, s: Environment) -> Vector:
    return (kinetic_j(s.body, p.body), potential_j(s), brakes_j(s.ports))


@port_shown.member(EnvironmentParams)
def _port(p: EnvironmentParams, s: Environment, user: int) -> PortShown:
    port = s.ports[user]
    return PortShown(port.v_s, in_touch(port), 0.0)


def in_touch(s: UserPort) -> bool:
    """Tell whether an avatar's contact holds or touches."""
    return s.avatar.present and touching(s.avatar.contact)
