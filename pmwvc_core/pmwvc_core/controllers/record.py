# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a controller: the laws of both ends, and the properties that other code asks for
by name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pmwvc_core.account import Entry
from pmwvc_core.baselines.tuning import Loop, Margins
from pmwvc_core.errors import ParameterError
from pmwvc_core.params import BaselineParams, MasterParams
from pmwvc_core.plugins import Record
from pmwvc_core.server.couplings import Coupling, backward

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
    """A controller: the laws of its ends, and its properties."""

    # whether packets carry wave variables; otherwise velocity and position up, force or position
    # down, with ``FLAG_DIRECT``
    waves: bool
    # the laws of the ends of one of another package, as :mod:`pmwvc_core.controllers.plugged` has
    # them; None: those of the library (of ``pmwvc``, where packets carry waves)
    device: Callable[[Any, Any, Any], tuple[Any, Any]] | None = None
    avatar: Callable[[Any, Any, Any], tuple[Any, Any]] | None = None
    # of one of the library without waves: from ``baseline.*`` and the tick [s], the NamedTuple by
    # whose type the families of :mod:`pmwvc_core.law.without_waves` choose its laws
    law: Callable[[BaselineParams, float], Any] | None = None
    sprung: bool = False  # whether the avatars of such a one hang on springs to their devices
    # from the parameters (with ``law`` those of ``baseline.*``) and the number of axes, the states
    # that the ends start from (NamedTuples)
    device_rest: Callable[[Any, int], Any] = lambda p, axes: ()
    avatar_rest: Callable[[Any, int], Any] = lambda p, axes: ()
    # how many ``extra`` signals a packet carries up and down, for a number of axes
    extra: Callable[[int], tuple[int, int]] = lambda axes: (0, 0)
    # dataclass of its own parameters, each a field by :func:`pmwvc_core.params.fields.field`; in a
    # scenario they stand in a group with the controller's name
    params: type | None = None
    # from the state of either law, the accounts that it keeps [J], in the order of ``accounts``
    energies: Callable[[Any], tuple[float, ...]] = lambda s: ()
    drifts: bool = False  # for older records: the exact model finds uniform motions by itself
    rule: Rule | None = None  # for tuning; None without parameters of its own
    # energy that the two ends of a user hold at the start by their parameters [J]
    storage_j: Callable[[MasterParams, BaselineParams], float] = lambda master, baseline: 0.0
    # how its own server end couples avatars and object; None: as ``server.coupling`` (waves only)
    coupling: Coupling | None = None
    # every account that an end may keep; those that no signal shows are remainders: the energy
    # budget closes whatever they are
    accounts: tuple[Entry, ...] = ()

    def __post_init__(self) -> None:
        """Refuse properties that contradict one another."""
        if self.coupling is None and not self.waves:
            raise ParameterError("coupling = None: server.coupling belongs to waves")
        if self.device is not None and self.avatar is None and not self.waves:
            raise ParameterError("avatar = None: a controller without waves needs both laws")

    def check(self, baseline: BaselineParams, loop: Loop) -> Margins:
        """Return by how much parameters meet the tuning rule; nothing without a rule."""
        return self.rule.check(getattr(baseline, self.rule.group), loop) if self.rule else {}
