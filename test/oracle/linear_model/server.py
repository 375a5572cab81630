# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server in the linear model: seats behind their ports around an object, and by which law."""

from collections.abc import Mapping, Sequence

from oracle.linear_model.blocks import column
from oracle.linear_model.couplings import LAWS, Body, Cube, Seat, Wall, remembered

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User

# Laws of environments of which the port knows nothing; none of them is compensated for.
UNKNOWN: Mapping[str, str] = {
    "wall": "one_step_delay",
    "wall_with_slope": "unwrapped",
    "cube": "carried",
}


def law_of(scenario: Scenario) -> str:
    """Return the law by which a scenario's server goes on."""
    if not has_waves(scenario.controller):
        return scenario.controller
    server = scenario.server
    return UNKNOWN[server.environment] if server.coupling == "unknown" else server.coupling


def _seat(user: User, names: tuple[str, ...], weight: int) -> Seat:
    contact, spring, own = user.contact, user.baseline.virtual_coupling, user.contact.impedance
    return Seat(
        column(contact.contact_stiffness),
        column(contact.contact_damping),
        column(user.master.impedance if own is None else own),
        names,
        weight,
        (column(spring.stiffness), column(spring.damping)),
    )


class Server:
    """The environment with its ports.

    Parameters
    ----------
    scenario
        Numbers may be columns.
    weights
        How many users like it each user stands for.
    """

    def __init__(self, scenario: Scenario, weights: Sequence[int]) -> None:
        law, params = law_of(scenario), scenario.server
        self._law, self._params = LAWS[law], params
        self.waves = has_waves(scenario.controller)
        names = remembered(law, params.integrator)
        self.body: Body = Cube(params) if params.environment == "cube" else Wall()
        self.seats = [
            _seat(user, names, weight)
            for user, weight in zip(scenario.users, weights, strict=True)
        ]

    def step(self, received: Sequence[list[Array]]) -> list[dict[str, Array]]:
        """Go one step on with a packet per user; return what may go back, by name."""
        names = ("u",) if self.waves else ("x", "xd")
        for seat, packet in zip(self.seats, received, strict=True):
            seat.rows.update(zip(names, packet, strict=True))
        self._law(self.seats, self.body, self._params)
        return [self._answer(seat) for seat in self.seats]

    def _answer(self, seat: Seat) -> dict[str, Array]:
        found = {"f": seat.rows["f"]}
        if "e" in seat.rows:
            found["x_s"] = self._place(seat)
        if self.waves:
            found["v"] = seat.rows["u"] - seat.ratio * seat.rows["f"]
        return found

    def _place(self, seat: Seat) -> Array:
        """Return where an avatar is; its own place of rest is left out."""
        return self.body.state[0] + seat.rows["e"] if self.body.names else seat.rows["e"]
