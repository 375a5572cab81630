# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A ROS node in the test's own process, in the test's own domain.

::

    with ros() as peer, NodeProcess("pmwvc_netem.node", {"seed": 3}) as netem:
        netem.await_output("relaying")
        peer.until(lambda: peer.node.count_subscribers("/user1/wave_up"))
        assert netem.stop() == 0
"""

import contextlib
import math
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from support.processes import PATIENCE_S, isolate

ANSWER_S = 3.0  # for an answer, until it is asked for again


class Peer:
    """A ROS node in the test's own process."""

    def __init__(self, *, domain: int | None = None, **options: Any) -> None:
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.signals import SignalHandlerOptions

        self.context = Context()
        no_handlers = SignalHandlerOptions.NO
        rclpy.init(
            args=[], context=self.context, domain_id=domain, signal_handler_options=no_handlers
        )
        self.node = Node("peer", context=self.context, **options)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)

    def until(self, condition: Callable[[], Any], *, within_s: float = PATIENCE_S) -> Any:
        """Serve the node until a condition holds; return what the condition returned."""
        end_s = time.monotonic() + within_s
        while not (result := condition()):
            if time.monotonic() > end_s:
                raise AssertionError(f"nothing came of it within {within_s} s")
            self._executor.spin_once(timeout_sec=0.02)
        return result

    def collect(
        self, kind: Any, topic: str, *, reliable: bool = False, raw: bool = False
    ) -> list[Any]:
        """Subscribe; return the list that messages go to."""
        messages: list[Any] = []
        self.subscribe(kind, topic, messages.append, reliable=reliable, raw=raw)
        return messages

    def subscribe(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Any], None],
        *,
        reliable: bool = False,
        raw: bool = False,
    ) -> None:
        """Subscribe."""
        self.node.create_subscription(kind, topic, callback, _qos(reliable), raw=raw)

    def publisher(self, kind: Any, topic: str, *, reliable: bool = False) -> Any:
        """Make a publisher."""
        return self.node.create_publisher(kind, topic, _qos(reliable))

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service and return its answer; call again where none comes: one is lost where the
        server has not found this client yet.
        """
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready)
        asked_s, calls = -math.inf, list[Any]()

        def answered() -> Any:
            nonlocal asked_s
            if time.monotonic() > asked_s + ANSWER_S:
                asked_s = time.monotonic()
                calls.append(client.call_async(request))
            return next((call for call in calls if call.done()), None)

        found = self.until(answered)
        self.node.destroy_client(client)
        return found.result()

    def set_parameters(self, node: str, values: Mapping[str, Any]) -> list[str]:
        """Set parameters of another node one by one; return why each was refused, or ""."""
        from rcl_interfaces.srv import SetParameters
        from rclpy.parameter import Parameter

        request = SetParameters.Request(
            parameters=[Parameter(n, value=v).to_parameter_msg() for n, v in values.items()]
        )
        answer = self.call(SetParameters, f"{node}/set_parameters", request)
        assert all(result.successful == (not result.reason) for result in answer.results)
        return [result.reason for result in answer.results]

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


def _qos(reliable: bool) -> Any:
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    policy = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(depth=10_000, reliability=policy)


@contextlib.contextmanager
def ros(**options: Any) -> Iterator[Peer]:
    """Join the test's own ROS domain (or ``domain``) as a node; ``options`` are those of
    ``rclpy.node.Node``.
    """
    isolate()
    peer = Peer(**options)
    try:
        yield peer
    finally:
        peer.close()
