# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master node: one haptic device of one user.

The main thread runs the force loop (:mod:`pmwvc_master.loop`); a second one serves parameters,
services and diagnostics, and hands complete new objects over, which the loop takes at a frame
boundary. Services: ``~/rearm`` (Trigger) after a fault; ``~/clutch`` (SetBool) uncouples the hand;
``~/start`` (Trigger) where ``start.paused`` is set. Relative topics: ``wave_up`` out,
``wave_down`` in, ``trace``.
"""

import secrets
import sys
import threading
import time
from collections.abc import Mapping
from functools import partial

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from pmwvc_core.controllers.library import has_waves, record_of
from pmwvc_core.law.user_tick import LATE_NS
from pmwvc_core.master.safety import COUPLED, STARTING, UNCOUPLED
from pmwvc_core.params import MasterParams, SafetyParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import hold_memory
from pmwvc_core.runtime.process import ERROR, OK, WARN, publish_health, run_node
from pmwvc_core.runtime.topics import RECORDED_QOS, WaveTopics
from pmwvc_core.runtime.watch import Watch
from pmwvc_core.transport.packet import Admission
from pmwvc_core.transport.receiver import diagnostics
from pmwvc_master.blocks import FrameBlock
from pmwvc_master.devices import limits_of, warnings_of_device
from pmwvc_master.devices.mapped import make_device
from pmwvc_master.loop import MasterLoop
from pmwvc_master.settings import declare_settings

FAREWELL_PERIODS = 3
OF_BLOCK = "start_ns first_tick state reason taken changes energy accounts orientation".split()
LATE_SAMPLES = f"ticks without a device sample of the last {LATE_NS / 1e6:g} ms"
STATES = ("starting", "coupled", "damping", "fault")


class Master:
    """The node: settings, device and loop."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.settings = declare_settings(node, self._change_master, self._change_safety)
        settings = self.settings
        epoch = secrets.randbits(64) or 1
        self.device = make_device(settings.device.plugin, settings.device_setup(node))
        self._epoch, self._seq, self._types = epoch, 0, messages.live_types()
        self._trace = node.create_publisher(self._types.MasterTrace, "trace", RECORDED_QOS)
        self.loop = MasterLoop(
            settings.make_force_loop(epoch, self.device.info), self.device, link=self._link(),
            publish_trace=self._publish_trace, tick_s=settings.master.tick_s, dof=settings.dof,
        )  # fmt: skip
        self._use_profile()
        self.device.open()
        master = settings.master
        rates = f"{1.0 / master.tick_s:.0f} force ticks and {1.0 / master.frame_s:.0f} packets"
        device = f"device {settings.device.plugin}"
        node.get_logger().info(f"{rates} per second; {device}; waiting for the server")
        self._late = 0  # late samples when last looked
        links = {f"{settings.name}/down": ("wave_down", "wave_up", self.loop.protocol.inbox)}
        self._watch = Watch(node, self.loop, links=links, reception="reception", epoch=epoch)
        node.create_service(Trigger, "~/rearm", self._rearm)
        node.create_service(SetBool, "~/clutch", self._clutch)
        publish_health(node, self._health)
        self.loop.memory = hold_memory()

    def _link(self) -> WaveTopics:
        settings = self.settings
        return WaveTopics(
            self.node, self._types, incoming="wave_down", outgoing="wave_up",
            admission=Admission(settings.token, out="up", into="down"), dof=settings.dof,
            extra=record_of(settings.controller).extra(settings.dof)[1],
        )  # fmt: skip

    def _publish_trace(self, loop: MasterLoop, block: FrameBlock) -> None:
        """Publish the ticks of a frame."""
        self._seq += 1
        if self.device.uncoupled and block.state == COUPLED:
            block.state, block.reason = STARTING, UNCOUPLED
        shift_ns = time.time_ns() - time.monotonic_ns()  # of the clock of ROS
        message = messages.master_trace(
            self._types, block.series(), stamp_ns=shift_ns + block.start_ns, epoch=self._epoch,
            seq=self._seq, period=loop.tick_s, dof=self.settings.dof, missed=block.missed,
            safety_events=loop.protocol.s.limits.events,
            hand_force_known=self.device.info.hand_force_known,
            **{name: getattr(block, name) for name in OF_BLOCK},
        )  # fmt: skip
        self._trace.publish(message)

    def _use_profile(self) -> None:
        """Show the force limit that holds; warn of parameters that do not fit the device."""
        node, asked = self.node, self.settings.given_safety.max_force
        allowed = limits_of(self.device.info, self.settings.given_safety).max_force
        if allowed < asked:
            text = f"lowered to the device's limit of {allowed:g} N"
            node.get_logger().warning(f"safety.max_force = {asked:g} N: {text}")
            node.set_parameters([Parameter("safety.max_force", value=float(allowed))])
        self._warn(self.settings.master)

    def _warn(self, master: MasterParams) -> None:
        given = self.settings
        force_n = self.loop.protocol.p.limits.max_force * given.given_device.scale
        lever_m = 0.0 if given.given_safety.max_torque else given.server.lever_m
        for text in warnings_of_device(
            self.device.info, master, given.given_device, force_n=force_n,
            torque_n_m=force_n * lever_m, waves=has_waves(given.controller), strict=given.strict,
        ):  # fmt: skip
            self.node.get_logger().warning(text)

    def run(self, stop: threading.Event) -> None:
        """Run the force loop."""
        self._watch.begin()
        self.loop.run(stop)

    def close(self) -> None:
        """Give the device back; leave the server the time to take the goodbye."""
        self.device.stop()
        self.device.close()
        self._watch.publish()
        # A reader may forget what it has not yet taken of a writer that is gone.
        newest = self.loop.protocol.inbox.newest
        time.sleep(FAREWELL_PERIODS * (newest.period if newest else self.settings.server.period_s))

    def _change_master(self, params: MasterParams) -> None:
        protocol = self.loop.protocol
        protocol.hand_over(lambda: protocol.configure(master=params))
        self._warn(params)

    def _change_safety(self, params: SafetyParams) -> None:
        protocol, lever_m = self.loop.protocol, self.settings.server.lever_m
        self.device.slew_n = params.max_slew * self.settings.master.tick_s
        allowed = limits_of(self.device.info, params, lever_m)
        protocol.hand_over(lambda: protocol.configure(given_safety=allowed))

    def _rearm(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Let the force come back after a fault."""
        self.loop.protocol.hand_over(self.loop.protocol.rearm)
        response.success = True
        response.message = "force rises from zero once the device is slow enough"
        return response

    def _clutch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        """Uncouple the hand, or couple it where it is now."""
        self.device.pressed, response.success = request.data, True
        response.message = "the avatar stays" if request.data else "the avatar follows the hand"
        return response

    def _health(self) -> tuple[int, str, Mapping[str, object]]:
        """Return level, text and values of the diagnostics, once a second."""
        protocol = self.loop.protocol
        values, missed = self._watch.look()
        late, self._late = protocol.s.late - self._late, protocol.s.late
        state = STATES[int(protocol.state)]
        values |= {
            "device samples": self.loop.work.samples, LATE_SAMPLES: protocol.s.late,
            "state": state, "reason": protocol.reason, "safety events": protocol.s.limits.events,
            "uncoupled": self.device.uncoupled,
        }  # fmt: skip
        values |= diagnostics(protocol.inbox, out="up", into="down")
        wrong, peers = self._watch.peers.look()
        values |= peers
        wrong += [f"{missed} deadlines missed"] if missed else []
        wrong += [f"{LATE_SAMPLES}: {late}"] if late else []
        text = "; ".join([f"{state}: {protocol.reason}".removesuffix(": "), *wrong])
        if state == "fault":
            return ERROR, text, values
        return (WARN if wrong or state == "damping" else OK), text, values


main = partial(run_node, "master", Master)

if __name__ == "__main__":
    sys.exit(main())
