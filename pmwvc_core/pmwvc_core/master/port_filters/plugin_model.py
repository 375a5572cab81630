# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A local model from elsewhere: a class with ``step(position, velocity, dt) -> force``.

The name of an entry point in the group ``pmwvc.local_models`` leads to a factory
``LocalModelParams -> model``. A class for the server's environments (group ``pmwvc.environments``)
fits where its code works elementwise: signals are arrays ``(1, ..., dof)``, one user.

With ``local(position, dt) -> (F0, G)`` (the next force is about F0 + G xd; ``position`` is the one
without xd, which moves it by ``dt`` xd) the loop is solved, and F0 + G xd at the middle of the
tick is the force. Without, the force is that of the tick before, which can make energy; so

    while more has come back than went in, the port is a matched damper, v2 = 0.

Its deficit is then at most what one tick gave out. A model that raises, or gives anything but a
finite force of the right shape, is a matched damper from then on; the reason is logged once.
"""

import logging
from typing import Any

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS, reason
from pmwvc_core.numeric import Array, Flag, Value, dot, maximum, where
from pmwvc_core.params import LocalModelParams
from pmwvc_core.plugins import PluginGroup
from pmwvc_core.state import Stateful

PLUGINS = PluginGroup(
    "pmwvc.local_models",
    "master.local_model.kind",
    "a local model",
    calls=("step",),
    own=("spring_damper",),
)
LARGEST_N = 1e6  # more is no force
logger = logging.getLogger(__name__)


class PluginModel(Stateful):
    """See the module. At rest at zero at first.

    Parameters
    ----------
    params
        Names the model.
    matched
        Slope of a matched damper, the impedance of the port [N s/m].

    Raises
    ------
    ParameterError
        If there is no such entry point, or it does not lead to a model.
    """

    BLOCKS = "_model"
    SIGNALS = "_x _f"
    MEMORY = "stored _broken"
    dissipated: Value = 0.0

    def __init__(self, params: LocalModelParams, *, matched: Value, tick_s: float) -> None:
        self._name = params.kind
        self._model: Any = PLUGINS.make(params.kind, params)
        self._sloped = hasattr(self._model, "local")
        self._matched = matched
        self._tick_s = tick_s
        self._broken = False
        self._x: Value = 0.0
        self._f: Value = 0.0
        self.stored: Value = 0.0  # what went in and has not come back

    def configure(self, params: LocalModelParams) -> None:
        """Go on: the model has its numbers from when it was made."""

    def offer(self) -> tuple[Value, Value]:
        """Return F0 and G: the model's, or those of a matched damper."""
        f0: Value = self._f
        slope: Value = 0.0
        if self._sloped and not self._broken:
            try:
                f0, slope = self._local()
            except PLUGIN_ERRORS as error:  # whatever the plug-in raises
                self._contain(error)
        if self._broken:
            return 0.0, self._matched
        short = self.stored < 0.0
        return where(short, 0.0, f0), where(short, self._matched, slope)

    def take(self, f: Value, xd: Value, there: Flag) -> None:
        """Count what went in, and let the model go on."""
        if there is not True:
            xd = where(there, xd, 0.0 * xd)
        self.stored = self.stored + dot(f, xd) * self._tick_s
        self._x = self._x + self._tick_s * xd
        if not self._broken:
            try:
                answer = self._model.step(_signal(self._x), _signal(xd), self._tick_s)
                self._f = self._good(answer)
            except PLUGIN_ERRORS as error:  # whatever the plug-in raises
                self._contain(error)

    def drop(self, gone: Flag) -> None:
        """Nothing: only the model could let go."""

    def _local(self) -> tuple[Value, Value]:
        f0, slope = self._model.local(_signal(self._x), 0.5 * self._tick_s)
        return self._good(f0), maximum(self._good(slope), 0.0)

    def _good(self, answer: Any) -> Value:
        """Return an answer in the form of the other signals.

        Raises
        ------
        ValueError
            If it is not finite or of another shape.
        """
        like = _signal(self._x)
        array = np.asarray(answer, dtype=float)
        if array.shape != like.shape:
            raise ValueError(f"shape {array.shape} where {like.shape} is expected")
        if not (np.abs(array) <= LARGEST_N).all():  # false for NaN
            raise ValueError("not a finite force")
        return array[0] if isinstance(self._x, np.ndarray) else float(array.item())

    def _contain(self, error: BaseException) -> None:
        self._broken = True
        logger.error(
            "master.local_model.kind = %r: %s; a matched damper replaces it",
            self._name,
            reason(error),
        )


def _signal(value: Value) -> Array:
    """Return a signal as the model sees it, ``(1, ..., dof)``."""
    return np.array(value, dtype=float, ndmin=1)[np.newaxis]
