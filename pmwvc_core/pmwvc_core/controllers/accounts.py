# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What both ends count [J], by name: the accounts kept, and the passages between signals.

A black box and its port count, for all users together::

    environment    sum F . xd h
    late_decoding  sum d h, with the power d of decoding with another force than F
    withheld       what the compensation took from the returning waves (negative: added)
    contained      sum |u|^2 h/2 while the environment did not answer and the port was a damper

Their sum is what went in at the ports, less the heat of the avatars' brakes.
"""

from pmwvc_core.account import Entry, Passage, Role
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import LINK_UP

LEVEL, SHOWN, TAKEN, WITHIN = Role.LEVEL, Role.SHOWN, Role.TAKEN, Role.WITHIN

# The master's port.
FILTER = Passage("filter", ("u_m",), ("u_m_lp",))
RATE_DROP = Passage("rate_drop", ("u_m_lp",), ("u_tx",))
HOLD = Passage("hold", ("v_rx",), ("v_m",))
VELOCITY_FILTER = Entry("velocity_filter", "kept by the velocity filter", TAKEN, "velocity filter")
FORCE_FILTER = Entry(
    "force_velocity_filter", "kept by the velocity filter of the force", WITHIN,
    part="velocity filter of the force",
)  # fmt: skip
OF_BANK = (
    Entry("bank_low_in", "to the server, behind the bank", WITHIN),
    Entry("bank_low_out", "from the server, before the bank", WITHIN),
    Entry("bank_high_in", "to the local model", WITHIN),
    Entry("bank_high_out", "from the local model", WITHIN),
    Entry("local_stored", "spring of the local model", TAKEN),
    Entry("local_dissipated", "damping of the local model", TAKEN),
)
POSITION_SPENT = Entry("position_spent", "released by the position feedback", Role.GIVEN)
OF_POSITION = (
    POSITION_SPENT,
    Entry("position_surplus", "energy tank of the position feedback", LEVEL),
    Entry("position_discarded", "energy above the cap of the tank, discarded", LEVEL),
    Entry("position_owed", "returned by the hold before its packet arrived", LEVEL),
)
NODE = Entry(
    "node", "not paid to packets yet, at the device's node", LEVEL,
    part="account of the device's node",
)  # fmt: skip
RELEASED = Entry(
    "playout_released", "passed on to the device's node beside the playout's wave", WITHIN
)
DISCARDED = Entry("playout_discarded", "in the playout beyond its cap, discarded", LEVEL)
OF_STRICT = (
    NODE,
    Entry("playout_given", "given out by the playout", LEVEL),
    RELEASED,
    Entry("playout_free", "in the playout, beyond what its wave needs", LEVEL),
    DISCARDED,
)

# The server's environment. Between the waves at all ports and the work of the forces at the
# avatars; between those and the object.
DECODING = Passage("late_decoding", ("ports",), ("avatars",))
CONTACTS = Passage("integration", ("avatars",), ("object",), ("springs",), ("dampers",))
BRAKES = Entry(
    "avatar_brakes", "dissipated by the brakes of the avatars", SHOWN,
    part="brakes of the avatars while no waves came",
)  # fmt: skip
OF_BLACK_BOX = (
    Entry("environment", "taken by the environment", SHOWN),
    Entry("late_decoding", "decoding with the force of the previous step", SHOWN),
    Entry("withheld", "withheld by the compensation", SHOWN, "compensation of the server port"),
    Entry(
        "contained", "dissipated in place of a failed environment", SHOWN,
        part="damper in place of a failed environment",
    ),
)  # fmt: skip
# Between what went in at the ports, less the heat of the avatars' brakes, and the work of the
# forces at the avatars; and what the environment does not report as stored.
PORT = Passage("residual", ("ports",), ("avatars",), (), ("late_decoding", "withheld"))
ENVIRONMENT = Passage("environment_heat", ("avatars",), ("contained",), ("reported",))

# Controllers without waves, at either end.
OF_PSPM = (
    Entry("pspm_tank", "energy tank of the set points", LEVEL),
    Entry("pspm_spring", "springs to the set points", LEVEL),
)
OF_TDPA = (
    Entry(
        "tdpa_dissipated", "dissipated by the passivity controller", TAKEN,
        part="passivity controller",
    ),
    Entry("tdpa_allowance", "energy that may still be released", LEVEL),
)  # fmt: skip
OF_WAVES = (
    VELOCITY_FILTER, FORCE_FILTER, *OF_BANK, *OF_POSITION, *OF_STRICT, BRAKES, *OF_BLACK_BOX,
)  # fmt: skip


def passages(params: MasterParams) -> tuple[Passage, ...]:
    """Return what waves pass on the strict channel: the links contain their playout. What the
    playout releases goes to the node beside the wave. Where the wave at the device is another one
    than the playout's, node and link down are one part.
    """
    if alters_wave(params):
        return LINK_UP, Passage("node_and_link_down", ("work", "v_s"), ("u_tx",))
    node = Passage(NODE.name, ("work", "v_m", "released"), ("u_tx",))
    return LINK_UP, node, Passage("link_down", ("v_s",), ("v_m", "released"))


def alters_wave(params: MasterParams) -> bool:
    """Tell whether the wave at the device is another one than that of the channel: port filters
    and position feedback belong to the node.
    """
    return params.velocity_filter.is_on or params.bank.is_on or params.position.is_on
