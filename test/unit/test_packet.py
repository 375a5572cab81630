# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets: numbers and running sums."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pmwvc_core.transport.packet import size_bytes

MESSAGES = Path(__file__).resolve().parents[2] / "pmwvc_msgs" / "msg"


@pytest.mark.parametrize("extra", [0, 1, 12])
@pytest.mark.parametrize("dof", [1, 3, 6])
def test_the_size_is_that_of_the_serialized_message(dof, extra):
    store = get_typestore(Stores.ROS2_JAZZY)
    name = "pmwvc_msgs/msg/Wave"
    store.register(get_types_from_msg((MESSAGES / "Wave.msg").read_text(), name))
    time = store.types["builtin_interfaces/msg/Time"]
    values = np.ones(dof)
    message = store.types[name](
        stamp=time(sec=1, nanosec=2),
        sent_ns=3,
        epoch=4,
        seq=5,
        period=0.008,
        wave=values,
        integral=values,
        energy=0.0,
        position=values,
        orientation=np.ones(4 if dof == 6 else 0),
        extra=np.ones(extra),
        echo_seq=0,
        echo_sent_ns=0,
        echo_hold_ns=0,
        flags=0,
        check=0,
        session=0,
        tag=0,
    )
    assert size_bytes(dof, extra) == len(store.serialize_cdr(message, name))
