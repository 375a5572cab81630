# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The opening of a connection: a file of the page, a socket that may connect, or a refusal."""

import http
from urllib.parse import urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from pmwvc_view.web import access

MOST_PAGES = 32


def answered(request: Request, rules: access.Access, *, port: int, pages: int) -> Response | None:
    """Return the answer to a request; None for a socket that may connect."""
    hosts = request.headers.get_all("Host")
    if why := rules.host_refused(hosts, port):
        return _answer(http.HTTPStatus.FORBIDDEN, why)
    path = urlsplit(request.path).path
    if path != access.SOCKET:
        file = access.page_file(path)
        if file is None:
            return _answer(http.HTTPStatus.NOT_FOUND, "there is no such file")
        return _answer(http.HTTPStatus.OK, file.content, file.kind)
    origins = request.headers.get_all("Origin")
    if why := rules.socket_refused(request.path, origins, hosts[0]):
        return _answer(http.HTTPStatus.FORBIDDEN, why)
    if pages >= MOST_PAGES:
        text = f"{MOST_PAGES} pages are connected already"
        return _answer(http.HTTPStatus.SERVICE_UNAVAILABLE, text)
    return None


def _answer(
    status: http.HTTPStatus, content: bytes | str, kind: str = "text/plain; charset=utf-8"
) -> Response:
    body = content if isinstance(content, bytes) else f"{content}\n".encode()
    headers = Headers({**access.HEADERS, "Content-Type": kind})
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)
