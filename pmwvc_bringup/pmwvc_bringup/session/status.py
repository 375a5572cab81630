# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The status of a running session: a few numbers per user, as a table or as a line."""

from dataclasses import dataclass, field

from rich.table import Table

STATES = ("starting", "coupled", "damping", "FAULT")


@dataclass
class UserStatus:
    """The newest values of one user; None where none came within the last second."""

    name: str
    tick_hz: float | None = None
    packet_hz: float | None = None
    delay_s: float | None = None  # of the emulated link up
    up_s: float | None = None  # as the server sees it; the division is a bound between two clocks
    down_s: float | None = None  # as the master sees it
    force_n: float | None = None
    state: int | None = None
    contact: bool | None = None


@dataclass
class Status:
    """The status of all users at one instant."""

    elapsed_s: float
    duration_s: float
    users: list[UserStatus] = field(default_factory=list)
    ended: list[str] = field(default_factory=list)  # nodes that ended

    def line(self) -> str:
        """Return everything on one line, for logs."""
        parts = [f"{self.elapsed_s:6.1f} / {self.duration_s:g} s"]
        parts += [" ".join([user.name, *_cells(user)]) for user in self.users]
        return " | ".join(parts + self.ended)

    def table(self) -> Table:
        """Return the same as a table, for terminals."""
        table = Table(
            title=f"{self.elapsed_s:.1f} / {self.duration_s:g} s",
            caption="; ".join(self.ended) or "Ctrl-C ends the session and writes the report",
            title_justify="left",
            caption_justify="left",
        )
        for name in ("user", "ticks", "packets", "delay", "force", "state"):
            table.add_column(name, justify="left" if name in ("user", "state") else "right")
        for user in self.users:
            table.add_row(user.name, *_cells(user))
        return table


def _cells(user: UserStatus) -> list[str]:
    """Return the texts of one user, in the order of the table's columns."""
    state = "no data" if user.state is None else STATES[user.state]
    if user.contact:
        state += ", contact"
    delays = _text(user.delay_s, "{:.1f} ms", 1e3)
    if user.up_s is not None and user.down_s is not None:  # as the ends see them
        delays = f"{user.up_s * 1e3:.1f}/{user.down_s * 1e3:.1f} ms"
    return [
        _text(user.tick_hz, "{:.0f} Hz"),
        _text(user.packet_hz, "{:.0f}/s"),
        delays,
        _text(user.force_n, "{:+.2f} N"),
        state,
    ]


def _text(value: float | None, form: str, factor: float = 1.0) -> str:
    return "-" if value is None else form.format(value * factor)
