# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Haply Inverse3 and Minverse, behind the Inverse Service of this machine (JSON over WebSocket).

The service answers every message with one state, which the next ``read`` takes: it is a tick old.
The rendered damping b, held for a tick T on a mass m, acts on the velocity of the tick before::

    v[k+1] = v[k] - r v[k-1],   r = b T/m:   overshoots from r = 1/4, unstable from 1 (not 2).

Of the answers that wait the newest counts; ``measured_ns`` is the tick of its message. A slow
service gets fewer forces, not older ones. One that is gone, or behind for a second (messages may
have had no answer), is called again; samples are invalid meanwhile. Service 3.5 takes forces as
``vector``, 3.1 as ``values``, and only 3.5 reports filters. Its axes: x right, y forward, z up.
"""

import contextlib
import json
import socket
from collections import deque
from dataclasses import dataclass
from time import monotonic_ns
from typing import Any

from websockets.exceptions import WebSocketException
from websockets.uri import parse_uri

from pmwvc_core.errors import DeviceError
from pmwvc_core.numeric import Value, flatten
from pmwvc_core.params.fields import Validated, fixed
from pmwvc_master.devices import STALE_NS, DeviceSample, DeviceSetup
from pmwvc_master.devices.inverse_link import InverseLink, LinkLost
from pmwvc_master.devices.profile import ORIGIN
from pmwvc_master.devices.vendor import OPEN_S, Measurement, VendorDevice

CALL_NS = 1_000_000_000  # between calls; and without an answer for so long the service is gone
MOST_ASKED = 2  # messages without an answer: the newest, and one that is late
NEW_IN_3_5 = {"basis", "mount", "filters"}
PLANT = ("gravity_compensation", "torque_scaling", "home_return", "preset", *sorted(NEW_IN_3_5))
NO_STATE = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError)
MOTION, START = ("position", "velocity"), "start the Haply Hub or haply-inverse-service"


@dataclass(frozen=True)
class HaplyParams(Validated):
    """Parameters of the node besides those of every device."""

    model: str = fixed("inverse3", "-", "model whose profile applies, or a YAML file with one")
    service: str = fixed("ws://localhost:10001", "-", "address of the Inverse Service")
    device_id: str = fixed("", "-", "id of the device (empty: the only one)")


class HaplyDevice(VendorDevice):
    """One device of the service; buttons are those of the first wireless VerseGrip."""

    buttons = 3

    def __init__(self, setup: DeviceSetup, params: HaplyParams | None = None) -> None:
        super().__init__("haply", setup, HaplyParams, params)
        self._where = f"haply.service = {self._params.service!r}"
        try:
            self._uri = parse_uri(self._params.service)
        except (WebSocketException, ValueError) as error:
            raise DeviceError(f"{self._where}: {error}") from error
        self._link: InverseLink | None = None
        self._id, self._form = self._params.device_id, ""  # of a force; empty: not known yet
        self._asked: deque[int] = deque()  # ticks [ns] of messages without an answer
        self._due_ns = self._call_ns = 0  # next call, if the service does not keep up

    def open(self) -> None:
        """Call the service, choose the device, check that its state can be used."""
        try:
            self._host = socket.gethostbyname(self._uri.host)
            self._link = InverseLink(self._uri, self._host)
            self._meet(first_of(self._link))
            self.write(self._zero)
            state = first_of(self._link)
        except (LinkLost, OSError, UnicodeError) as error:
            raise DeviceError(f"{self._where}: {error}; {START}") from error
        self._accept(state, self._asked.popleft())
        if not self._sample.valid:
            text = "sends no position or turn of a grip, is not calibrated, or has no power"
            raise DeviceError(f"haply device {self._id}: {text}")

    @staticmethod
    def look() -> str:
        """Return the devices that the service of this machine has; DeviceError without one."""
        uri = parse_uri(HaplyParams().service)
        try:
            with contextlib.closing(InverseLink(uri, socket.gethostbyname(uri.host))) as link:
                there = devices_of(json.loads(first_of(link)))
        except (LinkLost, OSError, *NO_STATE) as error:
            raise DeviceError(f"no Inverse Service at {HaplyParams().service}: {START}") from error
        return f"the service has {', '.join(there) or 'no device: plug it in and switch it on'}"

    def _meet(self, snapshot: bytes) -> None:
        """Choose the device from the first message of a connection, which has all settings."""
        try:
            found = devices_of(json.loads(snapshot))
            there = {each: dict(found[each].get("config") or {}) for each in found}
        except NO_STATE:
            raise LinkLost("what answers is no Inverse Service") from None
        if self._id not in there and (self._id or len(there) != 1):
            text = f"must be one of {', '.join(there) or 'none; plug it in and switch it on'}"
            raise DeviceError(f"haply.device_id = {self._id!r}: {text}")
        self._id = self._id or next(iter(there))
        config: dict[str, Any] = there[self._id]
        self._take(config.get("type", next(iter(self._profile.types), "")), self._id)
        self._form = "vector" if NEW_IN_3_5 & set(config) else "values"
        centred = "centered" in str(config.get("preset", ""))
        self._centre = ORIGIN if centred else self._profile.centre_m
        settings = json.dumps({name: config[name] for name in PLANT if name in config})
        self._tell(f"{self._id}, forces as {self._form!r}; settings of the service: {settings}")

    def read(self, due_ns: int) -> DeviceSample:
        """Take the answers that wait; for the first one wait half a tick at most."""
        self._due_ns, self._sample.fresh = due_ns, False
        if self._link is None:
            if due_ns < self._call_ns:
                return self._sample
            self._call_ns = due_ns + CALL_NS
            self._link = InverseLink(self._uri, self._host)
        try:
            self._listen(self._link)
        except (LinkLost, DeviceError) as error:
            self._lose(self._link, error)
        return self._sample

    def _listen(self, link: InverseLink) -> None:
        wait_s = (self._due_ns - monotonic_ns()) * 1e-9 + 0.5 * self._tick_s
        newest = None
        for message in link.take(max(wait_s, 0.0) if self._asked else 0.0):
            if not self._form:
                self._meet(message)
            elif self._asked:  # an answer more than there were questions tells nothing of its age
                newest = message, self._asked.popleft()
        if newest is not None:
            self._accept(*newest)
        oldest_ns = self._asked[0] if self._asked else self._due_ns
        if self._form and self._due_ns - oldest_ns <= STALE_NS:
            self._call_ns = oldest_ns + CALL_NS
        elif self._due_ns >= self._call_ns:
            raise LinkLost(f"no answer in time for {CALL_NS * 1e-9:g} s")
        else:
            self._sample.valid = False

    def _lose(self, link: InverseLink, error: Exception) -> None:
        """Let go of the connection, and call again later."""
        link.close()
        if self._sample.valid or self._form:
            self._tell(f"{self._id}: {error}; called again every second")
        self._link, self._form, self._sample.valid = None, "", False
        self._asked.clear()
        self._call_ns = self._due_ns + CALL_NS

    def _accept(self, message: bytes, measured_ns: int) -> None:
        """Take a state over."""
        self._sample.valid = False
        with contextlib.suppress(*NO_STATE):
            found = devices_of(there := json.loads(message))[self._id]
            state, status = found["state"], found.get("status", {})
            x, xd = ([float(state[f"cursor_{n}"][axis]) for axis in "xyz"] for n in MOTION)
            grip = (there.get("wireless_verse_grip") or [{}])[0].get("state", {})
            turned = [float(grip["orientation"][n]) for n in "xyzw"] if self._turn else ()
            buttons = sum(bool(grip.get("buttons", {}).get(n)) << k for k, n in enumerate("abc"))
            self._sense(Measurement(measured_ns, x, xd, turned, buttons), self._centre)
            self._sample.valid &= all(status.get(n, True) for n in ("calibrated", "power_supply"))
        self._sample.fresh, self._sample.measured_ns = True, measured_ns

    def write(self, f_m: Value) -> None:
        """Send the force on the hand at once; none behind a queue, which would make it old."""
        if len(self._asked) < MOST_ASKED:
            self._push(f_m)

    def stop(self) -> None:
        """Set the force to zero, behind whatever queue there is."""
        self._push(self._zero)

    def _push(self, f_m: Value) -> None:
        if self._link is not None and self._form:
            vector = dict(zip("xyz", (-flatten(f_m)).tolist(), strict=False))
            force = {"set_cursor_force": {self._form: vector}}
            message = {"inverse3": [{"device_id": self._id, "commands": force}]}
            try:
                self._link.send(json.dumps(message))
                self._asked.append(self._due_ns)
            except LinkLost as error:
                self._lose(self._link, error)

    def close(self) -> None:
        """Close when the last force is answered (it could be lost), and give the device back."""
        while self._link is not None and self._asked:
            self.read(monotonic_ns())
        if self._link is not None:
            self._link.close()
        self._link = None
        self._give_back()


def first_of(link: InverseLink) -> bytes:
    """Wait for the next message; only when a device is opened."""
    until = monotonic_ns() + round(OPEN_S * 1e9)
    while (left := until - monotonic_ns()) > 0:
        if messages := link.take(left * 1e-9):
            return messages[0]
    raise LinkLost(f"no answer in {OPEN_S:g} s")


def devices_of(message: Any) -> dict[str, dict[str, Any]]:
    """Return the devices of a message by id; one of ``NO_STATE`` where it is none."""
    return {str(each["device_id"]): each for each in message.get("inverse3", [])}
