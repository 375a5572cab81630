# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact linear model of a scenario: the core's own objects, stepped on the identity.

Both ends and the devices are brought to rest, where all signals are zero. Then every signal that
they carry from tick to tick and every packet under way is set to one in a run of its own, and all
runs are stepped side by side once around the hyperperiod (:mod:`.hyperperiod`). What the signals
are at the end is a row each of the transition matrix, on the states that matter
(:mod:`.reduction`).

Not here: motions that are no instability (:mod:`.rigid`).
"""

from collections.abc import Sequence
from typing import NamedTuple

from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.reduction import reduced
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario


class Linear(NamedTuple):
    """The linear model of a scenario whose numbers may be columns.

    Attributes
    ----------
    columns
        Column of every state, by its name and axis.
    rows
        ``(runs, states, states and inputs)``: the states after the hyperperiod.
    outputs
        ``x``, ``xd`` and ``f``, likewise; see :meth:`.hyperperiod.Hyperperiod.around`.
    placed
        Names of the positions and velocities that a uniform motion is given by.
    """

    loop: Hyperperiod
    columns: dict[tuple[str, int], int]
    rows: Array
    outputs: dict[str, Array]
    placed: frozenset[str]

    @property
    def states(self) -> list[str]:
        """Names of the states."""
        several = self.loop.dof > 1
        return [f"{name}, axis {axis}" if several else name for name, axis in self.columns]


def linearize(
    scenario: Scenario,
    *,
    live: bool = False,
    weights: Sequence[int] = (),
    outputs: bool = False,
    at_hand_s: Sequence[float] = (),
) -> Linear:
    """Return the linear model of a scenario; see :class:`.loop.Loop` for what is asked.

    Raises
    ------
    NonlinearError
        If something is not linear.
    PmwvcError
        If the hyperperiod is too long.
    """
    loop = Hyperperiod(scenario, live=live, weights=weights, at_hand_s=at_hand_s)
    return model_of(loop, *loop.around(outputs=outputs))


def model_of(loop: Hyperperiod, rows: Array, read: dict[str, Array]) -> Linear:
    """Return the model of what was stepped, on the states that matter."""
    entries = [(name, axis) for name in loop.names for axis in range(loop.dof)]
    moving = {loop.body, f"{loop.body}d"}
    moving |= {f"{line.name}.device.{x}" for line in loop.lines for x in ("x", "xd")}
    found = reduced(rows, list(read.values()), always=lambda j: entries[j][0] in moving)
    columns = {entries[j]: index for index, j in enumerate(found.kept)}
    deflections = {loop.deflection(index) for index in range(len(loop.lines))}
    springs = {name for name, _ in columns if name.endswith(".local.model.x")}
    placed = (moving | deflections | springs) & {name for name, _ in columns}
    outputs = dict(zip(read, found.read, strict=True))
    return Linear(loop, columns, found.rows, outputs, frozenset(placed))
