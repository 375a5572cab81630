# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of an environment: what makes it, and the properties that other code asks for by
name.
"""

from collections.abc import Callable
from dataclasses import dataclass

from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Record
from pmwvc_core.server.black_box.interface import BlackBox, EnvironmentSetup
from pmwvc_core.server.cube import Body


def still(params: ServerParams) -> float:
    """Return zero: nothing drives the environment [Hz]."""
    return 0.0


def passive(params: ServerParams) -> str:
    """Return nothing: the environment has no energy of its own."""
    return ""


@dataclass(frozen=True, kw_only=True)
class Environment(Record):
    """An environment: what makes it, and its properties.

    Attributes
    ----------
    make
        Makes it as a black box, at rest.
    body
        Makes the body whose equations every coupling knows, at rest at the origin; None: it is
        known as a black box only.
    noun
        What users touch, in reports.
    movable
        Whether it is an object that moves freely (``server.object_mass``).
    sloped
        Whether it reports its slope, with which the loop is solved.
    with_slope
        Name of the same environment that reports its slope; None where there is none.
    spring
        Whether each user touches a spring and damper that stand still: K and B of its contact.
    contact_law
        Whether reports give K and B of the users' contacts with it.
    drive_hz
        Frequency at which it moves by itself [Hz]; 0: not at all.
    own_energy
        Why it may give out energy of its own; empty where it has none.
    """

    make: Callable[[EnvironmentSetup], BlackBox]
    body: Callable[[ServerParams], Body] | None = None
    noun: str = "the object"
    movable: bool = False
    sloped: bool = False
    with_slope: str | None = None
    spring: bool = False
    contact_law: bool = True
    drive_hz: Callable[[ServerParams], float] = still
    own_energy: Callable[[ServerParams], str] = passive
