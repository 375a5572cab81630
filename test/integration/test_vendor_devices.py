# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master node with a vendor's device, by its name: the Haply's service is a fake; the library
of Force Dimension is not there.
"""

import math

import pytest
from support.inverse_service import InverseService
from support.played_server import USER, Server, master, signal
from support.processes import refused, ros

from pmwvc_master.node import main

pytestmark = [pytest.mark.integration]


def test_the_node_reads_a_haply_pushes_the_hand_and_ends_with_zero_force():
    with InverseService() as service, ros() as peer:
        given = {"device__plugin": "haply", "haply__service": service.url, "haply__axes": "y x z"}
        with master(peer, **given) as (process, blocks, _):
            server = Server(peer)
            service.position[1] += 0.02
            peer.until(lambda: blocks and math.isclose(blocks[-1].x[-1], 0.02))
            service.velocity[1] = 0.03
            while signal(blocks[-1:], "f_applied").max() < 0.1:  # damping, once it is coupled
                count = len(blocks)
                peer.until(lambda count=count: len(blocks) > count)
                server.answer()
            assert "forces as 'vector'" in process.output
            assert process.stop() == 0
        forces = []
        while not service.forces.empty():
            forces.append(service.force()[1])
        assert min(force["y"] for force in forces) < -0.1
        assert {(force["x"], force["z"]) for force in forces} <= {(0.0, 0.0), (-0.0, -0.0)}
        assert forces[-1] == {"x": 0.0, "y": 0.0, "z": 0.0}


def test_a_library_that_is_not_there_ends_the_node_with_one_line():
    given = {"device.plugin": "force_dimension", "force_dimension.library": "/nowhere/libdhd.so.3"}
    text = refused(main, given, arguments=USER)
    assert "force_dimension.library = '/nowhere/libdhd.so.3'" in text and "install the" in text
