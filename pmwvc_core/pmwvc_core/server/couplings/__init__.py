# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings of wave port and contact by name, how the algebraic loop is closed: the library, and
entry points of the group ``pmwvc.couplings``. Their laws are in :mod:`pmwvc_core.law.server`.

The velocity of an avatar depends on the force of its contact and the force on the velocity. A
coupling makes the two consistent in a step of the environment.
"""

from pmwvc_core.law.server.implicit import Implicit
from pmwvc_core.law.server.sampled import OneFrameLate, OneStepDelay, Unwrapped
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Records
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.couplings.record import Coupling, backward, forward

__all__ = ["COUPLINGS", "Coupling"]


def least_impedance(params: ServerParams, contact: ContactParams) -> float:
    """Return K T_VE + 2 B [N s/m]: the least impedance of a port that decodes a wave with the
    force of the step before and is passive at a wall (backward Euler).
    """
    stiffness, damping = float(contact.contact_stiffness), float(contact.contact_damping)
    return stiffness * params.period_s + 2.0 * damping


IMPLICIT = Coupling(
    name="implicit",
    words="Avatars and object are solved together: energy balances exactly in every step.",
    linear="implicit",
    law=lambda old_s, new_s: Implicit(0),
    moves=backward,
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
    moves=forward,
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
    Coupling,
    (IMPLICIT, ONE_STEP_DELAY, ONE_FRAME_LATE, UNWRAPPED, UNKNOWN),
    group="pmwvc.couplings",
    parameter="server.coupling",
    what="a coupling",
)
