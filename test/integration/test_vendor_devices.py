# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master node with a vendor's device, by its name: the Haply's service and the Touch's library
are fakes; the library of Force Dimension is not there.
"""

import math

import pytest
from support.fake_library import compiled, needs_compiler
from support.inverse_service import InverseService
from support.peers import ros
from support.played_server import USER, Server, master, signal
from support.processes import refused

from pmwvc_core.errors import DeviceError, ParameterError
from pmwvc_master.devices import check
from pmwvc_master.node import main

pytestmark = [pytest.mark.integration]
SOON = {"safety__soft_start_s": 0.05}  # whole, though a busy machine interrupts it


def test_the_node_reads_a_haply_pushes_the_hand_and_ends_with_zero_force():
    with InverseService() as service, ros() as peer:
        given = {"device__plugin": "haply", "haply__service": service.url, "device__axes": "y x z"}
        service.position[1] += 0.02  # before: a place that jumps is none of its velocity
        with master(peer, **given, **SOON) as (process, blocks, _):
            server = Server(peer)
            peer.until(lambda: blocks and math.isclose(blocks[-1].x[-1], 0.02))
            service.velocity[1] = 0.03
            while signal(blocks[-1:], "f_applied").max() < 0.1:  # damping, once it is coupled
                count = len(blocks)
                peer.until(lambda count=count: len(blocks) > count)
                server.answer()
            assert "forces as 'vector'" in process.output
            assert process.stop() == 0
        forces = []
        while not (forces and not service.forces.qsize() and not any(forces[-1].values())):
            forces.append(service.force()[1])
        assert min(force["y"] for force in forces) < -0.1
        assert {(force["x"], force["z"]) for force in forces} <= {(0.0, 0.0), (-0.0, -0.0)}
        assert forces[-1] == {"x": 0.0, "y": 0.0, "z": 0.0}


def test_a_library_that_is_not_there_ends_the_node_with_one_line():
    given = {"device.plugin": "force_dimension", "force_dimension.library": "/nowhere/libdhd.so.3"}
    text = refused(main, given, arguments=USER)
    assert "force_dimension.library = '/nowhere/libdhd.so.3'" in text and "install the" in text


def test_a_device_is_checked_as_the_master_would_have_it_and_not_pushed(monkeypatch):
    for name, time_s in {"BEFORE_S": 0.0, "REST_S": 0.5, "MOVE_S": 0.5}.items():
        monkeypatch.setattr(check, name, time_s)
    with InverseService(ids=("0C4E",)) as service:
        given = {"device.plugin": "haply", "haply.service": service.url, "dof": 3}
        lines = [line.text for line in check.check_device(given, 0.0)]
        assert "new samples a second" in lines[0] and lines[1].startswith("noise: 0.0 um")
        assert [line[:20] for line in lines[2:5]] == [f"motion along axis {k}:" for k in range(3)]
        forces = [service.force()[1] for _ in range(service.forces.qsize())]
        assert len(forces) > 100 and {value for force in forces for value in force.values()} == {0}
        with pytest.raises(DeviceError, match=r"--force 1\.5: must be 0\.\.1 N"):
            list(check.check_device(given, 1.5))
        with pytest.raises(ParameterError, match=r"haply\.axis: there is no such parameter"):
            list(check.check_device({**given, "haply.axis": "x"}, 0.0))


@needs_compiler
def test_the_node_reads_a_touch_from_the_librarys_thread_and_brakes_its_hand(tmp_path):
    """The fake moves at 0.1 m/s and stands still: the force is that of the damping."""
    library = str(compiled(tmp_path, "fake_hd.c", "libHD.so"))
    with ros() as peer:
        given = {"device__plugin": "touch", "touch__library": library, "touch__serial": "S-1"}
        with master(peer, **given, **SOON) as (process, blocks, _):
            server = Server(peer)
            peer.until(lambda: blocks and math.isclose(blocks[-1].x[-1], 0.01))
            while signal(blocks[-1:], "f_applied").max() < 1.0:
                count = len(blocks)
                peer.until(lambda count=count: len(blocks) > count)
                server.answer()
            assert signal(blocks, "f_applied").max() <= 3.3  # the profile's peak
            assert "max_force_n = 3.3 (CHAI3D 3.2" in process.output
            assert process.stop() == 0
