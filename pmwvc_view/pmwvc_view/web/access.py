# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rules of access: which address a page may come from, what it may load, its token.

The address is checked against other names that lead to this machine (a page of another site that
lets its own name point here), the origin against pages of other sites, the token against whoever
only knows the address.
"""

import contextlib
import ipaddress
import secrets
import socket
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

PAGE = Path(__file__).parents[1] / "page"
SOCKET = "/socket"
TOKEN_BYTES = 18
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
        "connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


def why_refused(host: str, port: int) -> str:
    """Return why nothing can listen on an address, in the system's words; "" where it can."""
    if not 0 <= port <= 65535:
        return "a port is 0..65535"
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        for family, _, _, _, address in found:
            socket.create_server(address, family=family).close()
    except OSError as error:
        return str(error.strerror)
    return ""


def new_token() -> str:
    """Return a random token for an address."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def page_file(path: str) -> tuple[bytes, str] | None:
    """Return content and type of the page's file with just this path below its folder, or None."""
    name = "index.html" if path == "/" else path.removeprefix("/")
    file = {each.relative_to(PAGE).as_posix(): each for each in PAGE.rglob("*.*")}.get(name)
    return (file.read_bytes(), TYPES[file.suffix]) if file and file.suffix in TYPES else None


class Access:
    """The checks of one server, which listens on an address and has a token for its socket."""

    def __init__(self, host: str, token: str) -> None:
        self._token = token
        self._loopback = is_loopback(host)
        own = socket.gethostname().lower()
        self._names = {"localhost", own, f"{own}.local", host.lower()}

    def host_refused(self, hosts: Sequence[str], port: int) -> str | None:
        """Return why a request with these `Host` headers is refused, or None."""
        if len(hosts) != 1:
            return "one Host header is needed"
        try:
            parts = urlsplit(f"//{hosts[0]}")
            name, given = parts.hostname, parts.port or 80
        except ValueError:
            return "the Host header is no address"
        if name is None or parts.username is not None or given != port:
            return "this server has another address"
        # A number is always its own: only names can be made to lead here by somebody else.
        own = name in self._names or _number(name) is not None
        if not (is_loopback(name) if self._loopback else own):
            return "this server has another address"
        return None

    def socket_refused(self, path: str, origins: Sequence[str], host: str) -> str | None:
        """Return why a socket is refused, or None; its ``Host`` header was checked before."""
        if list(origins) != [f"http://{host}"]:
            return "a page of another origin may not connect"
        given = parse_qs(urlsplit(path).query).get("token", [])
        if len(given) != 1 or not secrets.compare_digest(given[0].encode(), self._token.encode()):
            return "the address needs the right token"
        return None


def is_loopback(host: str) -> bool:
    """Tell whether an address is reached from this machine only."""
    number = _number(host)
    return host == "localhost" or (number is not None and number.is_loopback)


def _number(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host)
    return None
