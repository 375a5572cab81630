# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of other nodes, read and set by their ROS services, with their answers."""

import asyncio
import threading
import time
from collections.abc import Mapping
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python

from pmwvc_core.errors import PmwvcError

PATIENCE_S = 5.0
LOOK_S = 0.005


class Parameters:
    """The parameters of other nodes; an executor serves the node in another thread."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._setters: dict[str, Any] = {}

    def read(self, other: str, stop: threading.Event) -> dict[str, Any]:
        """Return all parameters of a node by name; PmwvcError where it does not answer."""
        listing = ListParameters.Request(depth=ListParameters.Request.DEPTH_RECURSIVE)
        names = list(
            self._call(ListParameters, f"{other}/list_parameters", listing, stop).result.names
        )
        request = GetParameters.Request(names=names)
        answer = self._call(GetParameters, f"{other}/get_parameters", request, stop)
        values = (parameter_value_to_python(value) for value in answer.values)
        return dict(zip(names, values, strict=True))

    async def set(self, other: str, values: Mapping[str, Any]) -> str:
        """Set parameters of a node together; return why it refused, or ""."""
        client = self._setters.get(other)
        if client is None:
            service = f"{other}/set_parameters_atomically"
            client = self._node.create_client(SetParametersAtomically, service)
            self._setters[other] = client
        if not client.service_is_ready():
            return f"{other} is not there"
        wanted = [
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
        call = client.call_async(SetParametersAtomically.Request(parameters=wanted))
        until_s = time.monotonic() + PATIENCE_S
        while not call.done():
            if time.monotonic() > until_s:
                return f"{other} did not answer within {PATIENCE_S:g} s"
            await asyncio.sleep(LOOK_S)
        result = call.result().result
        return "" if result.successful else str(result.reason)

    def _call(self, kind: Any, service: str, request: Any, stop: threading.Event) -> Any:
        client = self._node.create_client(kind, service)
        try:
            until_s = time.monotonic() + PATIENCE_S
            call = None
            while not stop.is_set() and time.monotonic() < until_s:
                if call is None and client.service_is_ready():
                    call = client.call_async(request)
                if call is not None and call.done():
                    return call.result()
                time.sleep(LOOK_S)
            raise PmwvcError(f"no answer to a call of {service}")
        finally:
            self._node.destroy_client(client)
