# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenario files: folders, YAML and the ``name=value`` texts of the command line.

A scenario itself: :mod:`pmwvc_core.scenario`. Works without ROS.
"""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import yaml

from pmwvc_analysis.recording.scenario_file import mapping_in, yaml_text
from pmwvc_analysis.recording.schemas import shares
from pmwvc_core.errors import ScenarioError
from pmwvc_core.params.names import flat_mapping, hint
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario

SUFFIXES = (".yaml", ".yml")
FILE_NAMES = ("operator.file", "trace_file", "server.scene")  # parameters that name a file


def folders() -> list[Path]:
    """Return the folders with the project's scenarios: source tree, or installed share."""
    here = Path(__file__).resolve()
    installed = [share / "pmwvc_bringup" / "config" for share in shares(here)]
    return [folder for folder in (here.parents[1] / "config", *installed) if folder.is_dir()]


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
            kinds = "file" if path.suffix in SUFFIXES else "session folder or scenario file"
            raise ScenarioError(name, [f"there is no such {kinds}"])
        return path
    files = known()
    if name not in files:
        near = hint(name, files, cutoff=0.4)
        ways = "pmwvc scenarios lists them; or give a .yaml file"
        raise ScenarioError(name, [f"there is no such scenario{near} ({ways})"])
    return files[name]


def read(path: Path) -> dict[str, object]:
    """Return a file's values by dotted name, with absolute paths of named files; ScenarioError."""
    return {"name": path.stem} | _with_files(mapping_in(path), path.resolve().parent)


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
            problems.append(f"--set {text}: {yaml_text(error)}")
    return _with_files(values, Path.cwd()), problems


def load(
    name: str,
    *,
    settings_texts: Iterable[str] = (),
    users: int | None = None,
    duration_s: float | None = None,
) -> Scenario:
    """Return a scenario with its options; ScenarioError with every mistake of file and options."""
    mapping = read(find(name))
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
