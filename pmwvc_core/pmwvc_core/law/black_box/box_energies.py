# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a black box reports as stored, what its port and its compensation count."""

from pmwvc_core.law.black_box.black_box import BlackBoxParams
from pmwvc_core.law.black_box.compensations import CompensationParams, Corrected, JointLedger
from pmwvc_core.law.black_box.secant import learned
from pmwvc_core.law.family import Family, no_accounts
from pmwvc_core.law.server.energies import PortShown, brakes_j, environment_energies, port_shown
from pmwvc_core.law.server.server_port import Environment
from pmwvc_core.law.vectors import Vector, is_zero

compensation_energies = Family("compensation_energies", no_accounts)  # (s, p) -> accounts [J]


@compensation_energies.member(Corrected)
def _deficit(s: Corrected, p: CompensationParams) -> Vector:
    return (p.period_s * s.deficit_w,)


@compensation_energies.member(JointLedger)
def _tank(s: JointLedger, p: CompensationParams) -> Vector:
    return (s.tank_j, s.granted_j, s.capped_j)


@environment_energies.member(BlackBoxParams)
def _energies(p: BlackBoxParams, s: Environment) -> Vector:
    e = s.body.accounts
    stored: Vector = (
        0.0, max(s.body.stored_j, 0.0), e.environment_j, e.late_j, e.withheld_j, e.contained_j
    )  # fmt: skip
    of_port = stored + compensation_energies(s.body.compensation, p.compensation)
    return of_port + (brakes_j(s.ports),)  # noqa: RUF005


@port_shown.member(BlackBoxParams)
def _shown(p: BlackBoxParams, s: Environment, user: int) -> PortShown:
    port = s.ports[user]
    touches = port.avatar.present and not is_zero(port.avatar.f)
    return PortShown(port.v_s, touches, learned(s.body.users[user].secant) if p.learns else 0.0)
