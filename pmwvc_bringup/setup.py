# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
from glob import glob

from setuptools import find_packages, setup

name = "pmwvc_bringup"

setup(
    name=name,
    version="0.1.0",
    packages=find_packages(include=[name, f"{name}.*"]),
    py_modules=["pmwvc"],  # the Python interface
    package_data={"": ["py.typed", "*.html", "*.j2", "*.css", "*.js"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{name}/config", sorted(glob("config/*.*"))),
        (f"share/{name}/config/scenes", sorted(glob("config/scenes/*"))),
        (f"share/{name}/layouts", sorted(glob("layouts/*"))),
    ],
    entry_points={"console_scripts": ["pmwvc = pmwvc_bringup.cli:main"]},
)
