# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The text of a scenario file as a mapping; what is not YAML is told with line and column."""

from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any

import yaml

from pmwvc_core.errors import ScenarioError


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


def mapping_in(path: Path) -> Mapping[str, Any]:
    """Return what a scenario file holds; ScenarioError where it cannot be read, is not YAML, or
    no mapping.
    """
    try:
        content = yaml.load(path.read_text("utf-8"), Loader=_Loader)
    except yaml.YAMLError as error:
        raise ScenarioError(str(path), [yaml_text(error)]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(str(path), [f"cannot be read: {error}"]) from None
    if not isinstance(content, Mapping):
        kind = "nothing" if content is None else type(content).__name__
        problem = f"holds {kind}; a mapping of names and values is expected"
        raise ScenarioError(str(path), [problem])
    return content


def yaml_text(error: yaml.YAMLError) -> str:
    """Return a YAML error on one line, with line and column."""
    if not isinstance(error, yaml.MarkedYAMLError):
        return f"is not YAML: {error}"
    mark = error.problem_mark
    position = f" in line {mark.line + 1}, column {mark.column + 1}" if mark else ""
    return f"is not YAML{position}: {error.problem}"
