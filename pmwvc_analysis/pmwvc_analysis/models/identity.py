# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The identity batch: every state and every input is one in a run of its own.

Signals are arrays ``(states and inputs, runs, dof)`` with parameters ``(runs, 1)``. The one is
small, a power of two: limits are far away, and scaling is exact. One run more has all of them at
once, weighted: it has to be the sum of the others.
"""

from collections.abc import Sequence

import numpy as np

from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_core.numeric import Array, Value

ONE = 2.0**-40
SUPERPOSED = 1e-9  # relative: what differs by more is not linear


class Identity:
    """Units, and signals as rows over them.

    Parameters
    ----------
    name
        Of the scenario.
    states
        Number of states; ``live`` are those of them that are set to one.
    inputs, runs, dof
        Number of inputs behind the states; columns of parameters; axes.
    one
        Amplitude of a unit, in SI units.
    """

    def __init__(
        self,
        name: str,
        *,
        states: int,
        live: Sequence[int],
        inputs: int,
        runs: int,
        dof: int,
        one: float = ONE,
    ) -> None:
        self._name, self._states, self._live = name, states, live
        self._runs, self._dof, self._one = runs, dof, one
        width = (len(live) + inputs) * dof
        rng = np.random.default_rng(width)
        # Of all runs in the last one.
        self._weights = rng.choice([-2.0, 1.0, 3.0], width) * rng.uniform(0.5, 1.0, width)

    @property
    def zero(self) -> Array:
        """A signal at rest."""
        return np.zeros((len(self._weights) + 1, self._runs, self._dof))

    def state(self, number: int) -> Array:
        """Return a live state, by its place among those, that is one along each axis."""
        first, dof = number * self._dof, range(self._dof)
        unit = np.zeros((len(self._weights) + 1, 1, self._dof))
        for axis in dof:
            unit[[first + axis, -1], 0, axis] = self._one * np.array(
                [1.0, self._weights[first + axis]]
            )
        return unit

    def input(self, index: int) -> Array:
        """Return an input that is one along each axis."""
        return self.state(len(self._live) + index)

    def rows(self, values: Sequence[Value], names: Sequence[str] = ()) -> Array:
        """Return signals as rows over all states and inputs, ``(runs, signals, columns)``.

        Raises
        ------
        NonlinearError
            If superposition does not hold.
        """
        weights, dof = self._weights, self._dof
        found = np.empty((len(values), len(weights) + 1, self._runs, dof))
        for index, value in enumerate(values):
            found[index] = value
        found /= self._one
        rows, together = found[:, :-1], found[:, -1]
        size = np.einsum("c,scrd->srd", np.abs(weights), np.abs(rows))
        largest = size.max(axis=(0, 2), keepdims=True, initial=0.0)
        off = np.abs(np.einsum("c,scrd->srd", weights, rows) - together)
        wrong = np.any(off > SUPERPOSED * largest, axis=1).ravel()
        if wrong.any():
            bad = {names[j // dof] if names else "packet" for j in np.flatnonzero(wrong).tolist()}
            raise NonlinearError(
                f"{self._name}: superposition does not hold for {', '.join(sorted(bad))}; "
                "there is no linear model; use 'pmwvc simulate'"
            )
        states = self._states * dof
        live = [j * dof + axis for j in self._live for axis in range(dof)]
        wide = np.zeros((self._runs, len(values) * dof, states + len(weights) - len(live)))
        columns = live + list(range(states, wide.shape[-1]))
        wide[:, :, columns] = rows.transpose(2, 0, 3, 1).reshape(*wide.shape[:2], len(weights))
        return wide
