# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages that were built are the ones in the source, and every field says what it is."""

import importlib
import re
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.serialization import deserialize_message, serialize_message

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
