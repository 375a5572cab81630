# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy accounts of a master's port on the strict channel (:mod:`.strict_port`)."""

from pmwvc_core.account import Entry, Passage, Role
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import LINK_UP

NODE = Entry(
    "node",
    "not paid to packets yet, at the device's node",
    Role.LEVEL,
    part="account of the device's node",
)
GIVEN = Entry("playout_given", "given out by the playout", Role.LEVEL)
FREE = Entry("playout_free", "in the playout, beyond what its wave needs", Role.LEVEL)
RELEASED = Entry(
    "playout_released", "passed on to the device's node beside the playout's wave", Role.WITHIN
)
DISCARDED = Entry("playout_discarded", "in the playout beyond its cap, discarded", Role.LEVEL)
ENTRIES = (NODE, GIVEN, RELEASED, FREE, DISCARDED)


def passages(params: MasterParams) -> tuple[Passage, ...]:
    """Return what waves pass: the links contain their playout. What the playout releases goes to
    the node beside the wave. Where the wave at the device is another one than the playout's, node
    and link down are one part.
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
