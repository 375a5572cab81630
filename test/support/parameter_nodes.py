# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Nodes with parameters: given at the start, bound to a group, changed while they run."""

from rclpy.parameter import Parameter

from pmwvc_core.runtime.parameters import ParameterBinding
from support.peers import ros


def node_given(**values):
    """Join ROS as a node that was given parameters; ``__`` stands for a dot."""
    overrides = [Parameter(n.replace("__", "."), value=v) for n, v in values.items()]
    return ros(parameter_overrides=overrides, automatically_declare_parameters_from_overrides=True)


def bind(node, prefix, kind, **options):
    """Bind a group; return its values at the start and the list that changes go to."""
    changes = []
    start = ParameterBinding(node).declare(prefix, kind, changes.append, **options)
    return start, changes


def change(node, **values):
    """Set parameters together; return the reason of refusal, "" where none."""
    wanted = [Parameter(n.replace("__", "."), value=v) for n, v in values.items()]
    return node.set_parameters_atomically(wanted).reason
