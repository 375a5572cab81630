# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers to compare with; both ends of a user's link share them.

The defaults are what the rules of :mod:`pmwvc_core.controllers.record` give, with a margin, for
the default device, hand and contact at 24 ms of delay each way.
"""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, group, parameter


@dataclass(frozen=True)
class VirtualCouplingParams(Validated):
    """Spring and damper between device and avatar, at both ends (Colgate 1995, Adams 1999)."""

    stiffness: float = parameter(300.0, "> 0 N/m", "stiffness of the coupling, K_c")
    damping: float = parameter(3.0, ">= 0 N s/m", "damping of the coupling, B_c")


@dataclass(frozen=True)
class TdpaParams(Validated):
    """Time-domain passivity observer and controller (Hannaford 2002, Ryu 2010)."""

    damping: float = parameter(
        9.0, ">= 0 N s/m", "local damping of the device's end, no part of the link"
    )
    damping_max: float = parameter(
        25.0, ">= 0 N s/m", "most damping that the device's end adds (rule: m/(10 T_c))"
    )
    fade_s: float = parameter(
        0.005, ">= 0 s", "time in which damping fades once it is not needed (0: at once)"
    )
    drift_share: float = parameter(
        0.1,
        "0..1",
        "share of the avatar's lag made up in a step, as far as energy allows (0: drifts)",
    )


@dataclass(frozen=True)
class PspmParams(Validated):
    """Passive set-position modulation (Lee and Huang 2010)."""

    stiffness: float = parameter(500.0, "> 0 N/m", "spring to the set point, K")
    damping: float = parameter(2.0, ">= 0 N s/m", "damping to ground, B (rule: > K T_c/2)")
    initial_j: float = parameter(0.02, ">= 0 J", "energy that each end starts with")
    cap_j: float = parameter(0.02, ">= 0 J", "energy above which the rest goes to the peer")


@dataclass(frozen=True)
class BaselineParams(Validated):
    """One group per controller that needs numbers of its own."""

    virtual_coupling: VirtualCouplingParams = group(VirtualCouplingParams)
    tdpa: TdpaParams = group(TdpaParams)
    pspm: PspmParams = group(PspmParams)
