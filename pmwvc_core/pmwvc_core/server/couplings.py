# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings of wave port and contact by name, how the algebraic loop is closed, and compensations
of the energy of late decoding (App. C section 5): the library, and entry points of the groups
``pmwvc.couplings`` and ``pmwvc.compensations``. Their laws are in :mod:`pmwvc_core.law.server` and
:mod:`pmwvc_core.law.black_box.compensations`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from pmwvc_core.account import Entry, Role
from pmwvc_core.law.black_box.compensations import AsPublished, Corrected, JointLedger
from pmwvc_core.law.family import NOTHING
from pmwvc_core.law.server.coupling import Implicit, OneFrameLate, OneStepDelay, Unwrapped
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Record, Records


@dataclass(frozen=True, kw_only=True)
class Coupling(Record):
    """A coupling: what makes its law, and its properties."""

    # makes, from what old and new velocity weigh by ``server.integrator`` [s], the NamedTuple by
    # whose type :data:`pmwvc_core.law.server.contacts.couple` chooses the law of a step;
    # None for a black box (:mod:`pmwvc_core.server.black_box`), and where a controller has its own
    law: Callable[[float, float], Any] | None = None
    parameters: tuple[str, ...] = ()  # of ``server.*`` that decide what it does, for reports
    # integrator of an avatar's displacement, by its name; empty: ``server.integrator``; None where
    # the avatar stands at the device's position
    moves: str | None = ""
    balanced: bool = False  # velocity and force of a step: F . xd = (|u|^2 - |v|^2)/2
    exact: bool = False  # stored energy and heat balance the waves to rounding in every step
    late: bool = False  # decodes with the force of the step before, xd = sqrt(2/b) u - F'/b
    black_box: bool = False  # the environment is known by its forces only
    # how the object moves: under the forces of the step ``held``, under those of the step before
    # (``held_before``), or by the ``midpoint`` rule
    object_motion: Literal["held", "held_before", "midpoint"] = "held_before"
    # whether the server returns no more energy than it received, whatever is touched
    passive: Callable[[ServerParams], bool] = lambda params: False
    # wave impedance [N s/m] from which on a contact with a wall is passive; None where no such
    # bound is known or needed
    least_impedance: Callable[[ServerParams, ContactParams], float] | None = None


def least_impedance(params: ServerParams, contact: ContactParams) -> float:
    """Return K T_VE + 2 B [N s/m]: the least impedance of a port that decodes a wave with the
    force of the step before and is passive at a wall (backward Euler).
    """
    stiffness, damping = float(contact.contact_stiffness), float(contact.contact_damping)
    return stiffness * params.period_s + 2.0 * damping


@dataclass(frozen=True, kw_only=True)
class Compensation(Record):
    """A compensation: what its law starts from, and its properties."""

    # makes, for a number of users, the state (a NamedTuple) by whose type the family
    # :data:`pmwvc_core.law.black_box.compensations.compensated` chooses the law
    rest: Callable[[int], Any]
    limits: bool = False  # whether it shortens returning waves: may withhold an environment
    # whether the port returns no more energy than it received, whatever the environment
    passive: Callable[[ServerParams], bool] = lambda params: False
    # energy that it may give out without having received it [J]
    allowance_j: Callable[[ServerParams], float] = lambda params: 0.0
    accounts: tuple[Entry, ...] = ()  # all that it keeps: numbers of its state, in their order


UNTREATED = Compensation(
    name="none", words="The energy of late decoding is not treated.", linear="none",
    rest=lambda users: NOTHING,
)  # fmt: skip
PRINTED = Compensation(
    name="printed",
    words="The compensation as published: it makes returning waves longer and generates energy.",
    linear="none", rest=lambda users: AsPublished((0.0,) * users),
)  # fmt: skip
CORRECTED = Compensation(
    name="corrected", words="Returning waves are shortened by what late decoding added.",
    linear="none", rest=lambda users: Corrected(0.0), limits=True,
    accounts=(Entry("debt", "deficit, recovered from later waves", Role.LEVEL),),
)  # fmt: skip
LEDGER = Compensation(
    name="ledger",
    words="All users together get back no more energy than they gave, and a declared allowance.",
    linear="none",
    rest=lambda users: JointLedger(0.0, 0.0, 0.0),
    limits=True,
    passive=lambda params: bool(min(params.allowance_w, params.allowance_j) == 0),
    allowance_j=lambda params: float(params.allowance_j) if params.allowance_w > 0.0 else 0.0,
    accounts=(
        Entry("tank", "energy tank of the server port", Role.LEVEL),
        Entry("granted", "taken from the allowance", Role.LEVEL),
        Entry("capped", "received above the cap, not stored", Role.LEVEL),
    ),
)
COMPENSATIONS: Records[Compensation] = Records(
    Compensation, (UNTREATED, PRINTED, CORRECTED, LEDGER), group="pmwvc.compensations",
    parameter="server.compensation", what="a compensation",
)  # fmt: skip

IMPLICIT = Coupling(
    name="implicit",
    words="Avatars and object are solved together: energy balances exactly in every step.",
    linear="implicit",
    law=lambda old_s, new_s: Implicit(0),
    moves="backward_euler",
    balanced=True,
    exact=True,
    object_motion="midpoint",
    passive=lambda params: True,
)
ONE_STEP_DELAY = Coupling(
    name="one_step_delay",
    words="Waves are decoded with the force of the step before: passive at a wall while "
    "K T_VE + 2 B <= b (backward Euler).",
    linear="one_step_delay",
    law=OneStepDelay,
    late=True,
    least_impedance=least_impedance,
)
ONE_FRAME_LATE = Coupling(
    name="one_frame_late",
    words="A wave moves the avatar one step late: no bound of its energy is known.",
    linear="one_frame_late",
    law=lambda old_s, new_s: OneFrameLate(0),
    moves="forward_euler",
    object_motion="held",
)
UNWRAPPED = Coupling(
    name="unwrapped",
    words="Each avatar is solved with its contact against the object as sampled: passive at a "
    "wall, except with forward Euler.",
    linear="unwrapped",
    law=Unwrapped,
    balanced=True,
)
# A black-box environment: position and velocity go in, a force comes out. A compensation treats
# the energy of late decoding; passivity depends on it.
UNKNOWN = Coupling(
    name="unknown",
    words="The environment is a black box: the server port accounts for the energy of late "
    "decoding, and its compensation limits it.",
    linear="unknown",
    black_box=True,
    parameters=("compensation",),
    passive=lambda params: COMPENSATIONS.of(params.compensation).passive(params),
    least_impedance=least_impedance,
)
COUPLINGS: Records[Coupling] = Records(
    Coupling, (IMPLICIT, ONE_STEP_DELAY, ONE_FRAME_LATE, UNWRAPPED, UNKNOWN),
    group="pmwvc.couplings", parameter="server.coupling", what="a coupling",
)  # fmt: skip
