# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The layouts of other viewers show topics and fields that exist; the messages that were built are
the ones in the source, and every field says what it is.
"""

import importlib
import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.topics import session_topics
from pmwvc_server.wires import FRAME

LAYOUTS = Path(__file__).resolve().parents[2] / "pmwvc_bringup" / "layouts"
USERS = ("user1", "user2")
LINKS = [f"{user}/{way}" for user in USERS for way in ("up", "down")]
TOPICS = {topic.name: topic for topic in session_topics(list(USERS), links=LINKS, people=True)}


def field_problem(topic, field):
    """Return why a topic has no such field, with an index for an array and none for a number."""
    if topic not in TOPICS:
        return f"no topic {topic}"
    name, index = re.fullmatch(r"(\w+)(\[\d+\])?", field).groups()
    kinds = dict(
        (words[1], words[0])
        for line in schemas.schema_text(TOPICS[topic].type_name).split("=" * 80)[0].splitlines()
        if len(words := line.partition("#")[0].split()) == 2
    )
    if name not in kinds:
        return f"{topic} has no field {name}"
    if kinds[name].endswith("[]") != (index is not None):
        return f"{topic} {name} is {kinds[name]}"
    return None


def foxglove():
    return json.loads((LAYOUTS / "foxglove.json").read_text("utf-8"))


def foxglove_paths():
    for name, panel in foxglove()["configById"].items():
        for path in panel.get("paths", []):
            yield name, path["value"]


def test_every_curve_of_foxglove_is_a_field_of_a_topic():
    paths = list(foxglove_paths())
    assert len(paths) > 15
    for name, value in paths:
        topic, filtered, field = re.fullmatch(r"(/[\w/]+)(\{.*\})?\.(.*)", value).groups()
        assert field_problem(topic, field) is None, (name, value)
        if filtered:
            key, wanted = re.fullmatch(r'\{(\w+)=="(.*)"\}', filtered).groups()
            assert field_problem(topic, key) is None
            assert wanted in LINKS


def test_every_panel_of_foxglove_is_shown_once():
    def panels(node):
        return [node] if isinstance(node, str) else panels(node["first"]) + panels(node["second"])

    content = foxglove()
    assert sorted(panels(content["layout"])) == sorted(content["configById"])
    scene = content["configById"]["3D!scene"]
    assert set(scene["topics"]) <= set(TOPICS) and scene["followTf"] == FRAME
    assert content["configById"]["DiagnosticSummary!health"]["topicToRender"] in TOPICS


def test_every_curve_of_plotjuggler_is_a_field_of_a_topic():
    curves = ElementTree.parse(LAYOUTS / "plotjuggler.xml").getroot().findall(".//curve")
    assert len(curves) > 15
    for curve in curves:
        topic, _, field = curve.attrib["name"].rpartition("/")
        assert field_problem(topic, field) is None, curve.attrib


def test_rviz_shows_the_markers_in_their_frame_and_quality_of_service():
    manager = yaml.safe_load((LAYOUTS / "session.rviz").read_text())["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == FRAME
    (markers,) = [d for d in manager["Displays"] if d["Class"].endswith("/MarkerArray")]
    topic = TOPICS[markers["Topic"]["Value"]]
    assert topic.type_name == "visualization_msgs/msg/MarkerArray"
    assert (markers["Topic"]["Reliability Policy"] == "Reliable") is topic.reliable


@pytest.mark.parametrize(
    ("topic", "field", "why"),
    [
        ("/user1/traces", "x[0]", "no topic"),
        ("/user1/trace", "y[0]", "no field y"),
        ("/user1/trace", "x", "is float64[]"),
        ("/user1/trace", "period[0]", "is float64"),
    ],
)
def test_a_wrong_curve_is_found(topic, field, why):
    assert why in field_problem(topic, field)


RMWError = rclpy_implementation.RMWError
FOLDER = Path(__file__).resolve().parents[2] / "pmwvc_msgs"
FILES = sorted((FOLDER / "msg").glob("*.msg"))
LINE = re.compile(r"(?P<type>\S+)\s+(?P<name>\w+)(?:=(?P<value>\d+))?\s+#\s(?P<comment>\S.*)")
UNITS = {
    "-", "s", "s, ns", "ns", "1/s", "m", "m/s", "N", "J", "sqrt(W)", "sqrt(W) s", "byte", "bit/s",
}  # fmt: skip


class Line(NamedTuple):
    """One field or constant of a message file."""

    type: str
    name: str
    value: int | None
    comment: str


def lines(file: Path) -> list[Line]:
    found = []
    for text in file.read_text("utf-8").splitlines():
        if text and not text.startswith("#"):
            match = LINE.fullmatch(text)
            assert match, f"{file.name}: not 'type name  # comment': {text}"
            value = match["value"] and int(match["value"])
            found.append(Line(match["type"], match["name"], value, match["comment"]))
    return found


def built(file: Path) -> Any:
    return getattr(importlib.import_module("pmwvc_msgs.msg"), file.stem)


def idl_name(ros_type: str) -> str:
    """Return a type as the generated classes spell it."""
    base, bounds = re.fullmatch(r"([\w/]+)(\[.*\])?", ros_type).groups()
    base = {"float32": "float", "float64": "double", "bool": "boolean"}.get(base, base)
    if bounds is None:
        return base
    limit = bounds.strip("[<=]")
    return f"sequence<{base}, {limit}>" if limit else f"sequence<{base}>"


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_what_was_built_is_the_source_and_every_number_has_a_unit(file: Path) -> None:
    fields = {}
    for line in lines(file):
        if line.value is not None:
            assert getattr(built(file), line.name) == line.value
            continue
        fields[line.name] = idl_name(line.type).replace("/msg/", "/")
        if line.type not in ("string", "string[]"):
            unit = re.match(r"\[([^]]*)\] \w", line.comment)
            assert unit and unit[1] in UNITS, f"{file.name}: {line.name}"
    assert built(file).get_fields_and_field_types() == fields


def test_every_message_is_built() -> None:
    text = (FOLDER / "CMakeLists.txt").read_text("utf-8")
    assert re.findall(r'"msg/(\w+)\.msg"', text) == [file.stem for file in FILES]
    names = "MasterTrace PacketFate Reception ServerTrace Wave"
    assert [file.stem for file in FILES] == names.split()


def test_a_wave_holds_up_to_six_degrees_of_freedom_and_no_more() -> None:
    wave = built(FOLDER / "msg" / "Wave.msg")
    full = serialize_message(wave(wave=[1.0] * 6))
    assert list(deserialize_message(full, wave).wave) == [1.0] * 6
    with pytest.raises(RMWError, match="Failed to serialize"):
        serialize_message(wave(wave=[1.0] * 7))
