# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A node's process, from its first line to its exit code. The main thread owns the loop; a second
one serves parameters, services and diagnostics; a third waits for signals, which only set an
event: ROS stays usable until the loop has sent its last packet. Exit code 0: asked to stop; 2: a
setting, file or device cannot be used, in one line; 1: a mistake of ours, with its traceback.
"""

import contextlib
import faulthandler
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.duration import Duration
from rclpy.exceptions import InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from pmwvc_core.errors import ParameterError, PmwvcError
from pmwvc_core.params.names import hint
from pmwvc_core.runtime.services import StartGate

OK, WARN, ERROR = 0, 1, 2
_SWITCH_S = 1e-4  # a loop that wakes gets the interpreter after this, not after 5 ms
# Below the loops, above other programs: a loop waits for the thread that holds the interpreter.
_PRIORITY = 10
_LAST_S = 10.0  # for what a recorder has not got yet; longer than that nothing is kept
_TEARDOWN_S = 5.0  # ROS needs some tens of milliseconds to remove a node
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_OWN_OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
_REFUSALS = (
    PmwvcError,
    InvalidNamespaceException,
    InvalidNodeNameException,
    rclpy_implementation.RCLError,
    rclpy_implementation.UnknownROSArgsError,
)


def run_node(name: str, build: Callable[[Node], Any], *, args: Sequence[str] | None = None) -> int:
    """Run a node until it is asked to stop; return the exit code. ``build`` declares the
    parameters and makes the node's work: ``run(stop)`` works until the event is set, ``close()``
    lets go of everything, once, also when ``run`` never was called. ``args`` are those of the
    process by default.
    """
    stop = threading.Event()
    sys.setswitchinterval(_SWITCH_S)
    with _signals_set(stop):
        try:
            node = _created(name, args)
        except _REFUSALS as error:
            rclpy.try_shutdown()
            return _refused(name, error)
        try:
            gate = StartGate(node)
            with contextlib.closing(build(node)) as work:
                refuse_undeclared(node)
                with _served(node, stop) as failures:
                    if gate.wait(stop):
                        work.run(stop)
            code = 1 if failures else 0
        except PmwvcError as error:
            code = _refused(name, error)
        except Exception:
            traceback.print_exc()
            code = 1
        _remove(node, code)
    return code


def publish_health(
    node: Node, collect: Callable[[], tuple[int, str, Mapping[str, object]]]
) -> None:
    """Publish a node's health on ``/diagnostics`` once a second: ``collect``, called by the
    executor's thread, returns level (``OK``, ``WARN``, ``ERROR``), one line for people, and values
    by name.
    """
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    name = node.get_fully_qualified_name()

    def publish() -> None:
        level, message, values = collect()
        pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        status = DiagnosticStatus(name=name, level=bytes((level,)), message=message, values=pairs)
        array = DiagnosticArray(status=[status])
        array.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(array)

    node.create_timer(1.0, publish)


def _created(name: str, args: Sequence[str] | None) -> Node:
    # Fast DDS looks into shared memory for a third of a second, and a loop that publishes waits.
    os.environ.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    rejected = remove_ros_args(args)[1 if args is None else 0 :]
    if rejected:
        raise ParameterError(
            f"{' '.join(rejected)}: not understood; parameters are given after --ros-args, "
            "like --ros-args -p name:=value"
        )
    try:
        return Node(name, automatically_declare_parameters_from_overrides=True)
    except ValueError as error:  # rclpy cannot infer the type of an empty list
        raise ParameterError(f"a parameter was given that is an empty list: {error}") from None


def _remove(node: Node, code: int) -> None:
    """Take a node whose work is closed out of the graph; exit if ROS never returns."""
    name = node.get_name()

    def give_up() -> None:
        print(f"{name}: ROS did not remove the node in {_TEARDOWN_S:g} s", file=sys.stderr)
        faulthandler.dump_traceback(all_threads=True)
        os._exit(code)

    until = time.monotonic() + _LAST_S
    for publisher in node.publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(until - time.monotonic(), 0.0)))
    timer = threading.Timer(_TEARDOWN_S, give_up)
    timer.daemon = True
    timer.start()
    node.destroy_node()
    rclpy.try_shutdown()
    timer.cancel()


def refuse_undeclared(node: Node) -> None:
    """Refuse parameters given to the node and not declared: ParameterError with each."""
    given = [n for n in node.get_parameters_by_prefix("") if not n.startswith(_OWN_OF_ROS)]
    known = [name for name in given if node.describe_parameter(name).description]
    unknown = [f"{n}: there is no such parameter{hint(n, known)}" for n in given if n not in known]
    if unknown:
        raise ParameterError("; ".join(unknown))


@contextlib.contextmanager
def _served(node: Node, stop: threading.Event) -> Iterator[list[Exception]]:
    """Serve parameters, services and timers in a thread of its own. An exception there ends the
    node; the executor is shut down once its thread has ended: rclpy takes guards away under one
    that spins.
    """
    failures: list[Exception] = []
    ended = threading.Event()
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def serve() -> None:
        with contextlib.suppress(OSError):  # the loop's own request is the one reported
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
        try:
            while not ended.is_set():
                executor.spin_once()
        except ExternalShutdownException:
            stop.set()
        except Exception as error:
            traceback.print_exc()
            failures.append(error)
            stop.set()

    thread = threading.Thread(target=serve, name="services", daemon=True)
    thread.start()
    try:
        yield failures
    finally:
        ended.set()
        executor.create_task(lambda: None)  # wakes it
        thread.join(_TEARDOWN_S)
        if thread.is_alive():  # the work is closed all the same: a device must be released
            print(f"a service did not return within {_TEARDOWN_S:g} s", file=sys.stderr)
            faulthandler.dump_traceback(all_threads=True)
        else:
            executor.shutdown()


@contextlib.contextmanager
def _signals_set(stop: threading.Event) -> Iterator[None]:
    """Have SIGINT and SIGTERM set an event: a signal writes to a pipe, and a thread reads that; a
    handler would run inside the main thread, where setting what it waits for can block.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    handlers = {number: signal.signal(number, lambda *_: None) for number in _SIGNALS}
    wakeup = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)  # blocked while the modules load

    def watch() -> None:
        while os.read(reader, 1):
            if stop.is_set():
                faulthandler.dump_traceback(all_threads=True)
            stop.set()

    thread = threading.Thread(target=watch, name="signals", daemon=True)
    thread.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        os.close(writer)
        thread.join()
        os.close(reader)


def _refused(name: str, error: Any) -> int:
    print(f"{name}: " + " ".join(str(error).split()), file=sys.stderr)
    return 2
