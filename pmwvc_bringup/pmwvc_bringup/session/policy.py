# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policy of a session: an enclave per node, with the topics and services that it has and
no others.

``ros2 security create_permission`` makes signed DDS permissions from it, which deny everything
else. An operator's enclave, of the page or the command line, may call the nodes' services, read
what they publish, and send targets of hands.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from pmwvc_analysis.recording.format.topics import session_topics
from pmwvc_core.runtime.records import record_of

EVERY_NODE = ("/rosout", "/parameter_events", "/diagnostics")  # published
OF_ROS = (
    "describe_parameters get_parameter_types get_parameters get_type_description list_parameters "
    "set_parameters set_parameters_atomically"
).split()
OF_NODES = ("start", "matched")


@dataclass(frozen=True)
class Access:
    """One node's enclave: its topics and services by full name."""

    enclave: str
    namespace: str
    node: str
    publishes: Sequence[str] = ()
    subscribes: Sequence[str] = ()
    replies: Sequence[str] = ()
    requests: Sequence[str] = ()


def accesses(users: Sequence[str]) -> list[Access]:
    """Return the enclaves of a session with these users, with an emulated network."""
    nodes = [
        _node(
            "server",
            publishes=["/server/trace", "/server/reception", "/markers", *_down_in(users)],
            subscribes=[f"/server/{user}/wave_up" for user in users],
        ),
        _node(
            "netem",
            publishes=[
                "/netem/links",
                "/netem/fates",
                *(f"/server/{user}/wave_up" for user in users),
                *(f"/{user}/wave_down" for user in users),
            ],
            subscribes=[*(f"/{user}/wave_up" for user in users), *_down_in(users)],
        ),
        _node("recorder", subscribes=_recorded(users)),
        *map(_master, users),
    ]
    operator = Access(
        "/pmwvc/operator",
        "/",
        "operator",
        publishes=[
            *EVERY_NODE,
            "/view/restart",
            *(f"/{user}/hand/{name}" for user in users for name in ("target", "held")),
        ],
        subscribes=[*_recorded(users), *(topic for node in nodes for topic in node.publishes)],
        requests=[service for node in nodes for service in node.replies],
    )
    return [*nodes, operator]


def policy(users: Sequence[str]) -> str:
    """Return the policy file (SROS2, version 0.2.0)."""
    root = ElementTree.Element("policy", version="0.2.0")
    enclaves = ElementTree.SubElement(root, "enclaves")
    for access in accesses(users):
        enclave = ElementTree.SubElement(enclaves, "enclave", path=access.enclave)
        profiles = ElementTree.SubElement(enclave, "profiles")
        named = {"ns": access.namespace, "node": access.node}
        profile = ElementTree.SubElement(profiles, "profile", named)
        for kind, right, names in (
            ("topic", "publish", access.publishes),
            ("topic", "subscribe", access.subscribes),
            ("service", "reply", access.replies),
            ("service", "request", access.requests),
        ):
            if names:
                group = ElementTree.SubElement(profile, f"{kind}s", {right: "ALLOW"})
                for name in sorted(set(names)):
                    ElementTree.SubElement(group, kind).text = name
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _node(name: str, *, publishes: Iterable[str] = (), subscribes: Iterable[str] = ()) -> Access:
    """Return the enclave of a node of the session itself."""
    return Access(
        f"/pmwvc/{name}",
        "/",
        name,
        publishes=[*EVERY_NODE, *_with_records(publishes)],
        subscribes=list(subscribes),
        replies=[f"/{name}/{service}" for service in (*OF_ROS, *OF_NODES)],
    )


def _master(user: str) -> Access:
    """Return the enclave of a user's master, device topics and a hand from outside included."""
    own = ("trace", "reception", "wave_up", "measured_cv", "measured_cf", "device/servo_cf")
    others = ("wave_down", "hand/target", "hand/held", "device/measured_cp", "device/measured_cv")
    return Access(
        f"/pmwvc/{user}",
        f"/{user}",
        "master",
        publishes=[*EVERY_NODE, *_with_records(f"/{user}/{name}" for name in own)],
        subscribes=[f"/{user}/{name}" for name in others],
        replies=[f"/{user}/master/{service}" for service in (*OF_ROS, *OF_NODES, "rearm")],
    )


def _with_records(topics: Iterable[str]) -> Iterator[str]:
    for topic in topics:
        yield topic
        if topic.endswith(("/wave_up", "/wave_down")):
            yield record_of(topic)


def _down_in(users: Sequence[str]) -> Iterator[str]:
    return (f"/server/{user}/wave_down" for user in users)


def _recorded(users: Sequence[str]) -> list[str]:
    links = [f"{user}/{way}" for user in users for way in ("up", "down")]
    return [topic.source for topic in session_topics(users, links=links, people=True)]
