# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a controller: both ends, and the properties that other code asks for by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pmwvc_core.account import Entry
from pmwvc_core.baselines.tuning import Loop, Margins
from pmwvc_core.errors import ParameterError
from pmwvc_core.master.brake import HandBrake
from pmwvc_core.master.controller import MasterController
from pmwvc_core.params import BaselineParams, MasterParams, ServerParams
from pmwvc_core.plugins import Record
from pmwvc_core.server.black_box.containment import Call
from pmwvc_core.server.black_box.interface import BlackBox
from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.couplings import Coupling
from pmwvc_core.server.couplings.record import backward
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.transport.packet import Packer
from pmwvc_core.wave.playout import Playout

MasterMaker = Callable[[MasterParams, BaselineParams], MasterController]
StrictMaker = Callable[[MasterParams, Playout, Packer, HandBrake], MasterController]
ServerMaker = Callable[[ServerParams, Sequence[UserPort]], ServerController]
BlackBoxMaker = Callable[[ServerParams, Sequence[UserPort], BlackBox, Call], ServerController]

# The server's end of a controller without waves: the object moves under the forces held.
HELD = Coupling(
    name="held forces",
    words="The object moves under the forces of the step before.",
    moves=backward,
)


@dataclass(frozen=True)
class Rule:
    """The parameters of a controller: the rule they should meet, and the ranges of a search."""

    group: str  # field of BaselineParams with the controller's parameters
    check: Callable[[Any, Loop], Margins]  # by how much parameters meet the rule
    ranges: Mapping[str, tuple[float, float]]  # least and largest value searched, by parameter

    def __post_init__(self) -> None:
        """Refuse a group that does not exist."""
        if not hasattr(BaselineParams(), self.group):
            raise ParameterError(f"group = {self.group!r}: BaselineParams has no such group")


@dataclass(frozen=True, kw_only=True)
class Controller(Record):
    """A controller: what makes its ends, and its properties.

    Attributes
    ----------
    waves
        Whether packets carry wave variables; otherwise velocity and position up, force or position
        down, with ``FLAG_DIRECT``.
    make_master, make_server
        Make the ends, at rest, with no user present.
    make_strict
        Makes the master's end on the strict channel, between the playout of the returning wave and
        the sender of the outgoing one, with the brake of the device; None where the controller
        has none, and ``channel`` does not matter. At the server the strict channel is that of
        receiver and sender alone.
    make_black_box
        Makes the server's end around a black box (``server.coupling = unknown``); None where a
        wave controller has none.
    drifts
        Whether users and object may move on together uniformly without a force, as far as the
        linear model goes.
    rule
        Tuning rule and ranges of the search; None without parameters of its own.
    storage_j
        Energy that the two ends of a user hold at the start by their parameters [J].
    coupling
        How the controller's own server end couples avatars and object; None: as
        ``server.coupling`` selects (waves only).
    accounts
        Every account that an end may keep. Those that no signal shows are remainders: the energy
        budget closes whatever they are.
    """

    waves: bool
    make_master: MasterMaker
    make_server: ServerMaker
    make_strict: StrictMaker | None = None
    make_black_box: BlackBoxMaker | None = None
    drifts: bool = False
    rule: Rule | None = None
    storage_j: Callable[[MasterParams, BaselineParams], float] = lambda master, baseline: 0.0
    coupling: Coupling | None = None
    accounts: tuple[Entry, ...] = ()

    def __post_init__(self) -> None:
        """Refuse properties that contradict one another."""
        if self.coupling is None and not self.waves:
            raise ParameterError("coupling = None: server.coupling belongs to waves")

    def check(self, baseline: BaselineParams, loop: Loop) -> Margins | None:
        """Return by how much parameters meet the tuning rule; None without a rule."""
        if self.rule is None:
            return None
        return self.rule.check(getattr(baseline, self.rule.group), loop)
