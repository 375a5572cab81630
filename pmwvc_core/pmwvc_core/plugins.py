# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Plug-ins by name: factories that other packages offer as entry points of a group.

A laboratory adds one by installing a package of its own; nothing here changes. Not here: which
groups there are, and what a factory gets and makes.
"""

from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pmwvc_core.errors import FOREIGN, ParameterError, PmwvcError, reason


@dataclass(frozen=True)
class PluginGroup:
    """The plug-ins of one kind."""

    group: str  # of the entry points
    parameter: str  # that names one
    what: str  # a factory makes, with its article
    calls: tuple[str, ...]  # that it must have
    attributes: tuple[str, ...] = ()  # that it must have besides
    own: tuple[str, ...] = ()  # names that need no plug-in
    error: type[PmwvcError] = ParameterError  # what is raised

    def installed(self) -> dict[str, EntryPoint]:
        """Return the installed plug-ins by name, without importing any."""
        return {point.name: point for point in sorted(entry_points(group=self.group))}

    def required(self, name: str) -> EntryPoint:
        """Return an installed plug-in, without importing it.

        Raises
        ------
        PmwvcError
            Of the type ``error``, if there is none of this name; names those there are.
        """
        points = self.installed()
        if name not in points:
            raise self.error(
                f"{self.parameter} = {name!r}: not installed; there are: "
                f"{', '.join([*self.own, *points]) or 'none'}. "
                f"A plug-in is a package with an entry point in the group {self.group!r}"
            )
        return points[name]

    def where(self, name: str) -> str:
        """Return the parameter, the name and the entry point of a plug-in, for messages."""
        return f"{self.parameter} = {name!r} ({self.required(name).value})"

    def load(self, name: str) -> Any:
        """Import what the entry point of a plug-in names.

        Raises
        ------
        PmwvcError
            Of the type ``error``, if there is no such plug-in, or it cannot be imported.
        """
        point = self.required(name)
        try:
            return point.load()
        except FOREIGN as error:  # whatever a foreign package raises while it is imported
            raise self.error(f"{self.where(name)} cannot be imported: {reason(error)}") from error

    def make(self, name: str, setup: Any) -> Any:
        """Return what the factory of a plug-in makes of ``setup``.

        Raises
        ------
        PmwvcError
            Of the type ``error``, if there is no such plug-in (naming those there are), if it
            cannot be imported or made (with the reason), or if it lacks what it must have.
        """
        factory, where = self.load(name), self.where(name)
        try:
            made = factory(setup)
        except PmwvcError:
            raise
        except FOREIGN as error:  # whatever a foreign factory raises
            raise self.error(f"{where} cannot be made: {reason(error)}") from error
        lacks = [call for call in self.calls if not callable(getattr(made, call, None))]
        lacks += [name for name in self.attributes if not hasattr(made, name)]
        if lacks:
            raise self.error(f"{where} is not {self.what}: it lacks {', '.join(lacks)}")
        return made
