# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that rclpy or rosbags decoded, and their fields that are read and written by name.

Fields, units and meaning are those of the ``.msg`` files. A recording of before may lack some.
"""

from typing import Any, TypeAlias

# Classes of either decoder, which have nothing in common.
Trace: TypeAlias = Any  # MasterTrace or ServerTrace
MasterTrace: TypeAlias = Any
ServerTrace: TypeAlias = Any
Wave: TypeAlias = Any
LinkState: TypeAlias = Any
Reception: TypeAlias = Any
PacketFate: TypeAlias = Any
Stamp: TypeAlias = Any  # a time of ROS

PER_AXIS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")  # of a tick
PER_TICK = {"lateness": "f", "compute": "f", "looked": "I"}  # typecodes
OF_OBJECT = ("x_o", "xd_o", "target")  # of a step
