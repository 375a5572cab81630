# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server in the linear model: seats behind their ports around an object, and by which law."""

from collections.abc import Mapping, Sequence

from pmwvc_analysis.models.blocks import column
from pmwvc_analysis.models.couplings import LAWS, Body, Cube, Seat, Wall, remembered
from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.simulation.scenario import Scenario, User

# Laws of environments of which the port knows nothing; none of them is compensated for.
UNKNOWN: Mapping[str, str] = {
    "wall": "one_step_delay",
    "wall_with_slope": "unwrapped",
    "cube": "carried",
}


def law_of(scenario: Scenario) -> str:
    """Return the law by which a scenario's server goes on."""
    if scenario.controller != "pmwvc":
        return scenario.controller
    server = scenario.server
    return UNKNOWN[server.environment] if server.coupling == "unknown" else server.coupling


def at_server(user: User) -> Value:
    """Return the wave impedance of a user's port at the server, a number or a column [N s/m]."""
    own = user.contact.impedance
    return user.master.impedance if own is None else own


class Server:
    """The environment with its ports.

    Parameters
    ----------
    law
        Name of the coupling, or ``direct``.
    params
        The environment.
    contacts, impedances, weights
        Per user.
    """

    def __init__(
        self,
        law: str,
        params: ServerParams,
        contacts: Sequence[ContactParams],
        impedances: Sequence[Value],
        weights: Sequence[int],
    ) -> None:
        self._law, self._params = LAWS[law], params
        self.direct = law == "direct"
        names = remembered(law, params.integrator)
        self.body: Body = Cube(params) if params.environment == "cube" else Wall()
        self.seats = [
            Seat(column(c.contact_stiffness), column(c.contact_damping), column(b), names, w)
            for c, b, w in zip(contacts, impedances, weights, strict=True)
        ]

    def step(self, received: Sequence[list[Array]]) -> list[list[Array]]:
        """Go one step on with a packet per user; return those that go back."""
        names = ("x", "xd") if self.direct else ("u",)
        for seat, packet in zip(self.seats, received, strict=True):
            seat.rows.update(zip(names, packet, strict=True))
        self._law(self.seats, self.body, self._params)
        if self.direct:
            return [[seat.rows["f"]] for seat in self.seats]
        return [
            [seat.rows["u"] - seat.ratio * seat.rows["f"], self._place(seat)]
            for seat in self.seats
        ]

    def _place(self, seat: Seat) -> Array:
        """Return where an avatar is; its own place of rest is left out."""
        return self.body.state[0] + seat.rows["e"] if self.body.names else seat.rows["e"]
