# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

name = "pmwvc_master"

setup(
    name=name,
    version="0.1.0",
    packages=find_packages(include=[name, f"{name}.*"]),
    package_data={"": ["py.typed", "*.html", "*.j2", "*.css", "*.js", "profiles/*/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    entry_points={
        "console_scripts": ["master = pmwvc_master.node:main"],
        "pmwvc.devices": [
            "simulated = pmwvc_master.devices.simulated:SimulatedDevice",
            "ros_topic = pmwvc_master.devices.ros_topic:RosTopicDevice",
            "haply = pmwvc_master.devices.haply:HaplyDevice",
            "lerobot = pmwvc_master.devices.lerobot:LerobotDevice",
            "touch = pmwvc_master.devices.touch:TouchDevice",
            "force_dimension = pmwvc_master.devices.force_dimension:ForceDimensionDevice",
        ],
    },
)
