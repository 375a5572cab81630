# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user who presses a wall with a given force: linear throughout."""

from pmwvc_core.scenario.reader import parse_scenario


def wall(**overrides):
    """The scenario; ``overrides`` by dotted name."""
    return parse_scenario(
        {
            "name": "press",
            "duration_s": 5.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 1,
            "device": {"mass": 0.2, "damping": 1.0},
            "operator": {"kind": "constant"},
            "server": {
                "environment": "wall",
                "contact": "bilateral",
                "contact_stiffness": 800.0,
                "contact_damping": 5.0,
            },
            "task": {"kind": "free"},
        },
        overrides=overrides,
    )
