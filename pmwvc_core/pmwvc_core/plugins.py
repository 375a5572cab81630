# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Plug-ins by name, which other packages offer as entry points of a group: a *factory* makes an
object (a device, an environment), a *record* describes a controller, a coupling, a link effect.
Code of theirs is asked behind a guard, which counts where it fails.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from pmwvc_core.errors import PLUGIN_ERRORS, ParameterError, PmwvcError, reason

A = TypeVar("A")
F = TypeVar("F")


@dataclass(frozen=True)
class PluginGroup:
    """The plug-ins of one kind."""

    group: str  # of the entry points
    parameter: str  # that names one
    what: str  # a factory makes, with its article
    calls: tuple[tuple[str, ...], ...]  # that it must have, one of each
    attributes: tuple[str, ...] = ()  # that it must have besides
    own: tuple[str, ...] = ()  # names that need no plug-in
    error: type[PmwvcError] = ParameterError  # what is raised

    def required(self, name: str) -> EntryPoint:
        """Return an installed plug-in, not imported; ``error``, with those there are, without."""
        points = installed(self.group)
        if name not in points:
            raise self.error(
                f"{self.parameter} = {name!r}: not installed; there are: "
                f"{', '.join(dict.fromkeys([*self.own, *points])) or 'none'}. "
                f"A plug-in is a package with an entry point in the group {self.group!r}"
            )
        return points[name]

    def where(self, name: str) -> str:
        """Return the parameter, the name and the entry point of a plug-in, for messages."""
        return f"{self.parameter} = {name!r} ({self.required(name).value})"

    def load(self, name: str) -> Any:
        """Import what a plug-in's entry point names; ``error`` where that cannot be done."""
        with refused(self.where(name), self.error, "imported"):
            return self.required(name).load()

    def make(self, name: str, setup: Any) -> Any:
        """Return what the factory of a plug-in makes of ``setup``; a PmwvcError of the type
        ``error`` where it cannot be imported or made, or lacks what it must have.
        """
        factory, where = self.load(name), self.where(name)
        with refused(where, self.error):
            made = factory(setup)
        lacks = [
            " or ".join(names)
            for names in self.calls
            if not any(callable(getattr(made, name, None)) for name in names)
        ]
        lacks += [name for name in self.attributes if not hasattr(made, name)]
        if lacks:
            raise self.error(f"{where} is not {self.what}: it lacks {', '.join(lacks)}")
        return made


@contextmanager
def refused(
    where: str, error_type: type[PmwvcError] = ParameterError, cannot_be: str = "made"
) -> Iterator[None]:
    """Refuse by an ``error_type`` what a plug-in fails to make; a PmwvcError passes."""
    try:
        yield
    except PmwvcError:
        raise
    except PLUGIN_ERRORS as error:  # whatever a plug-in raises
        raise error_type(f"{where} cannot be {cannot_be}: {reason(error)}") from error


class BadAnswer(Exception):
    """Code from outside answered with something that is no answer."""


class Unanswered(BadAnswer):
    """It has not answered in time, or is still busy with an earlier step."""


class Faults:
    """Count of the steps, or calls, in which what a parameter names was faulty, and the text of
    the last fault; where the parameter names several, each fault says its own ``value``.
    """

    def __init__(self, parameter: str, value: str = "") -> None:
        self._parameter, self._value = parameter, value
        self.steps = 0
        self.text = ""
        self.what = parameter.removeprefix("server.")
        self.replaced = self.what == "environment"  # by a damper, in those steps

    def guarded(self, ask: Callable[[], A], fallback: F, value: str = "") -> A | F:
        """Return what code from outside answers; where it fails the fallback, and count a step."""
        try:
            return ask()
        except PLUGIN_ERRORS as error:  # whatever it raises
            self.note(error, value)
            return fallback

    def note_users(self, bad: Iterable[bool], what: str) -> None:
        """Count a step where the answer is bad for any user."""
        if who := [user for user, is_bad in enumerate(bad) if is_bad]:
            self.note(BadAnswer(f"returned {what} for users {who}"))

    def note(self, error: BaseException, value: str = "") -> None:
        """Count a step."""
        what = str(error) if isinstance(error, BadAnswer) else f"raised {reason(error)}"
        self.steps += 1
        self.text = f"{self._parameter} = {value or self._value!r} {what}"


def installed(group: str) -> dict[str, EntryPoint]:
    """Return the plug-ins of a group by name, sorted, without importing any."""
    return {point.name: point for point in sorted(entry_points(group=group))}


@dataclass(frozen=True, kw_only=True)
class Record:
    """The properties of an exchangeable part: other code asks for these and compares no names."""

    name: str  # as in a scenario and as the entry point
    words: str = ""  # a sentence for predictions and reports: what it does or guarantees
    # name of the record whose linear model stands for this one (its own or the nearest), or None
    linear: str | None = None


R = TypeVar("R", bound=Record)


class Records(Generic[R]):
    """The records of one kind by name: those of the library, then those of other packages."""

    def __init__(
        self, kind: type[R], library: Iterable[R], *, group: str, parameter: str, what: str
    ) -> None:
        self.kind = kind
        self.library: Mapping[str, R] = {record.name: record for record in library}
        self.met = dict(self.library)  # with those of other packages asked for so far
        self.plugins = PluginGroup(group, parameter, what, calls=(), own=tuple(self.library))

    def installed(self) -> tuple[str, ...]:
        """Return the names of records from other packages, without importing any."""
        return tuple(name for name in installed(self.plugins.group) if name not in self.library)

    def names(self) -> tuple[str, ...]:
        """Return every name that a scenario may give, those of the library first."""
        return (*self.library, *self.installed())

    def of(self, name: str) -> R:
        """Return a record by name; ParameterError where there is none that can be used."""
        if name not in self.library:
            self.met[name] = imported(self, name)
        return self.met[name]


@cache
def imported(records: Records[R], name: str) -> R:
    """Return a record of another package; what raises is asked again the next time."""
    plugins, kind = records.plugins, records.kind
    record, where = plugins.load(name), plugins.where(name)
    if not isinstance(record, kind):
        raise ParameterError(
            f"{where} is not {plugins.what}: it is a {type(record).__name__}, must be a record "
            f"{kind.__module__.removesuffix('.record')}.{kind.__name__}"
        )
    if record.name != name:
        raise ParameterError(f"{where} has another name: {record.name!r}")
    if record.linear not in (None, name, *records.library):
        raise ParameterError(
            f"{where}: linear = {record.linear!r}: must be None or one of "
            f"{', '.join([name, *records.library])}"
        )
    return record
