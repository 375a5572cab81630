# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenario files: folders, YAML and the ``name=value`` texts of the command line.

A scenario itself: :mod:`pmwvc_core.scenario`. Works without ROS.
"""

import os
import sys
from collections.abc import Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from pmwvc_core.errors import ScenarioError
from pmwvc_core.params.names import flat_mapping, hint
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario

SUFFIXES = (".yaml", ".yml")
FILE_NAMES = ("operator.file", "trace_file")  # parameters that name a file


class _Loader(yaml.SafeLoader):
    """Safe YAML that refuses a name given twice; YAML itself keeps the last."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Build a mapping; a repeated key is an error with its line."""
        seen: set[Hashable] = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, Hashable) and key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"{key} is given twice", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


def folders() -> list[Path]:
    """Return the folders with the project's scenarios: source tree, or installed share."""
    here = Path(__file__).resolve()
    source = here.parents[1] / "config"
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    prefixes += map(str, here.parents)  # installed for one user, or into a folder
    shares = [Path(prefix, "share", "pmwvc_bringup", "config") for prefix in prefixes if prefix]
    return [folder for folder in (source, *shares) if folder.is_dir()]


def known() -> dict[str, Path]:
    """Return the scenarios that come with the project by name, sorted."""
    found: dict[str, Path] = {}
    for folder in folders():
        for path in folder.glob("*.yaml"):
            found.setdefault(path.stem, path)
    return dict(sorted(found.items()))


def find(name: str) -> Path:
    """Return the file of a scenario given by name or as a file; ScenarioError if there is none."""
    path = Path(name).expanduser()
    if path.suffix in SUFFIXES or os.sep in name:
        if not path.is_file():
            raise ScenarioError(name, ["there is no such file"])
        return path
    files = known()
    if name in files:
        return files[name]
    near = hint(name, files, cutoff=0.4)
    raise ScenarioError(
        name,
        [f"there is no such scenario{near} (pmwvc scenarios lists them; or give a .yaml file)"],
    )


def read(path: Path) -> dict[str, object]:
    """Return the values of a scenario file by dotted name, with absolute paths of named files;
    ScenarioError where it cannot be read or is not YAML, with line and column.
    """
    try:
        content = yaml.load(path.read_text("utf-8"), Loader=_Loader)
    except yaml.YAMLError as error:
        raise ScenarioError(str(path), [_yaml_text(error)]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(str(path), [f"cannot be read: {error}"]) from None
    if not isinstance(content, Mapping):
        kind = "nothing" if content is None else type(content).__name__
        raise ScenarioError(
            str(path), [f"holds {kind}; a mapping of names and values is expected"]
        )
    return _with_files(content, path.resolve().parent)


def settings(texts: Iterable[str]) -> tuple[dict[str, object], list[str]]:
    """Return the values of ``name=value`` texts (YAML scalars), and the problems."""
    values: dict[str, object] = {}
    problems = []
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            problems.append(f"--set {text}: must be name=value, e.g. link.delay_s=0.016")
            continue
        try:
            values[name] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            problems.append(f"--set {text}: {_yaml_text(error)}")
    return _with_files(values, Path.cwd()), problems


def load(
    name: str,
    *,
    settings_texts: Iterable[str] = (),
    users: int | None = None,
    duration_s: float | None = None,
) -> Scenario:
    """Return a scenario with its options; ScenarioError with every mistake of file and options."""
    path = find(name)
    mapping = read(path)
    overrides, problems = settings(settings_texts)
    try:
        scenario = parse_scenario(
            mapping, source=name, overrides=overrides, users=users, duration_s=duration_s
        )
    except ScenarioError as error:
        raise ScenarioError(name, [*problems, *error.problems]) from None
    if problems:
        raise ScenarioError(name, problems)
    return scenario


def to_yaml(scenario: Scenario) -> str:
    """Return the complete scenario as the text of a scenario file."""
    return yaml.safe_dump(scenario.to_dict(), sort_keys=False, allow_unicode=True, width=99)


def _with_files(values: Mapping[str, object], base: Path) -> dict[str, object]:
    """Return values by dotted name, with absolute paths of files that are below ``base``."""
    return {
        name: str(base / value)
        if name.endswith(FILE_NAMES)
        and isinstance(value, str)
        and value
        and (base / value).is_file()
        else value
        for name, value in flat_mapping(values).items()
    }


def _yaml_text(error: yaml.YAMLError) -> str:
    """Return a YAML error on one line, with line and column."""
    if not isinstance(error, yaml.MarkedYAMLError):
        return f"is not YAML: {error}"
    mark = error.problem_mark
    position = f" in line {mark.line + 1}, column {mark.column + 1}" if mark else ""
    return f"is not YAML{position}: {error.problem}"
