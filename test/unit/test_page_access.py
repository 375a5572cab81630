# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server of the page: what it serves, and who may connect."""

import http.client
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.page_sockets import PATIENCE_S, TOKEN, HandmadeSession, served

from pmwvc_view import protocol
from pmwvc_view.protocol import Request, read
from pmwvc_view.web.access import Access, why_refused


@pytest.fixture
def server():
    with served(HandmadeSession()) as running:
        yield running


def get(server, path, **headers):
    connection = http.client.HTTPConnection(server.host, timeout=PATIENCE_S)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer, content


def upgrade(server, path, **headers):
    wanted = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Origin": f"http://{server.host}",
    }
    return get(server, path, **(wanted | headers))[0].status


def test_address_that_cannot_be_listened_on_is_refused_with_the_reason(server):
    assert why_refused("127.0.0.1", 0) == why_refused("localhost", 0) == ""
    assert "already in use" in why_refused("127.0.0.1", server.port)
    assert why_refused("127.0.0.1", 65536) == "a port is 0..65535"
    assert "Cannot assign requested address" in why_refused("192.0.2.1", 0)


def test_page_and_its_files_are_served_under_a_policy_that_loads_nothing_from_elsewhere(server):
    script = "/vendor/ogl/core/Mesh.js", "text/javascript"
    for path, kind in (("/", "text/html"), ("/page.css", "text/css"), script):
        answer, content = get(server, path)
        assert answer.status == 200 and content
        assert answer.headers["Content-Type"].startswith(kind)
        policy = answer.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy and "script-src 'self'" in policy
        assert "unsafe" not in policy
        assert answer.headers["Referrer-Policy"] == "no-referrer"
    assert "http" not in policy


@pytest.mark.parametrize(
    "path",
    [
        *("/../server.py", "/%2e%2e/server.py", "/page/../../node.py", "/etc/passwd", "//", "/."),
        *("/vendor/../../node.py", "/vendor/ogl", "/vendor/ogl/LICENSE", "/vendor//ogl/README.md"),
    ],
)
def test_nothing_outside_the_page_is_served(server, path):
    assert get(server, path)[0].status == 404


def test_right_token_host_and_origin_connect(server):
    assert upgrade(server, f"/socket?token={TOKEN}") == 101
    localhost = f"localhost:{server.port}"
    given = {"Host": localhost, "Origin": f"http://{localhost}"}
    assert upgrade(server, f"/socket?token={TOKEN}", **given) == 101


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/socket", {}),
        ("/socket?token=", {}),
        ("/socket?token=other", {}),
        (f"/socket?token={TOKEN}&token={TOKEN}", {}),
        (f"/socket?token={TOKEN}", {"Origin": "http://evil.example"}),
        (f"/socket?token={TOKEN}", {"Origin": "null"}),
        (f"/socket?token={TOKEN}", {"Origin": "http://127.0.0.1:1"}),
        (f"/socket?token={TOKEN}", {"Host": "evil.example"}),
        (f"/socket?token={TOKEN}", {"Host": "127.0.0.1:1"}),
        ("/", {"Host": "evil.example"}),
    ],
)
def test_wrong_token_host_or_origin_is_refused(server, path, headers):
    assert upgrade(server, path, **headers) == 403


@given(name=st.from_regex(r"[a-z][a-z0-9-]{0,20}(\.[a-z]{2,5}){1,2}", fullmatch=True))
def test_no_name_of_others_leads_to_an_opened_server(name):
    opened = Access("0.0.0.0", TOKEN)
    assert opened.host_refused(["192.168.1.20:80"], 80) is None
    assert opened.host_refused([f"{name}:80"], 80) is not None


@given(st.text() | st.recursive(st.none() | st.floats() | st.text(), st.lists).map(json.dumps))
def test_any_text_is_a_request_or_refused_with_a_reason(text):
    try:
        assert isinstance(read(text), Request)
    except protocol.ProtocolError as error:
        assert str(error)
