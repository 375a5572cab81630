# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Admission of packets: every corrupted bit, other sessions, forged packets, floods; tokens."""

import os
import secrets
import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.packer import Packer

from pmwvc_bringup.cli import main
from pmwvc_core.errors import ParameterError
from pmwvc_core.runtime.token_files import read_token, write_token
from pmwvc_core.runtime.topics import packet_of, wave_bytes
from pmwvc_core.transport.packet import (
    BURST,
    LARGEST_RATE_HZ,
    Admission,
    Receipt,
    Token,
    size_bytes,
)

KEY = Token(0xABC, "", bytes(range(32)))
MASTER = {"out": "up", "into": "down"}
SERVER = {"out": "down", "into": "up"}


def ends(token=KEY, user="user1"):
    """Return the two ends of a user's link."""
    token = token and token.of(user)
    return Admission(token, **MASTER), Admission(token, **SERVER)


def message(seq=1, epoch=1, dof=1):
    packer = Packer(epoch, period=0.008)
    packer.seq = seq - 1
    return wave_bytes(packer.pack(0.5, 0.1, seq * 8_000_000), 7, dof=dof)


@pytest.mark.parametrize("token", [None, KEY], ids=["open", "token"])
def test_each_end_takes_what_the_other_has_sealed(token):
    master, server = ends(token)
    up, down = master.sealed(message()), server.sealed(message())
    assert server.judge(up, 0) is None and master.judge(down, 0) is None
    assert packet_of(up).session == (0xABC if token else 0)


@given(bit=st.integers(0, 8 * size_bytes(2) - 1), keyed=st.booleans())
def test_every_corrupted_bit_is_found(bit, keyed):
    master, server = ends(KEY if keyed else None)
    data = bytearray(master.sealed(message(dof=2)))
    data[bit // 8] ^= 1 << bit % 8
    assert server.judge(bytes(data), 0) is Receipt.CORRUPTED


@pytest.mark.parametrize(
    ("forger", "verdict"),
    [
        (Admission(KEY.of("user2"), **MASTER), Receipt.FORGED),  # another user
        (Admission(KEY.of("user1"), **SERVER), Receipt.FORGED),  # the server's own, sent back
        (Admission(Token(0xABC, "user1", bytes(32)), **MASTER), Receipt.FORGED),  # no token
        (Admission(Token(0xDEF, "", KEY.key).of("user1"), **MASTER), Receipt.OTHER_SESSION),
        (Admission(None, **MASTER), Receipt.OTHER_SESSION),  # without a checksum
    ],
)
def test_a_packet_that_another_has_sealed_is_refused(forger, verdict):
    sealed = forger.sealed(message())
    assert ends()[1].judge(sealed, 0) is verdict
    assert ends(None)[1].judge(message(), 0) is None  # an open session takes what is not sealed
    others = Admission(Token(0xDEF, "", KEY.key).of("user1"), **MASTER).sealed(message())
    assert ends(None)[1].judge(others, 0) is Receipt.OTHER_SESSION


def test_a_true_packet_that_was_changed_and_given_a_new_checksum_is_forged():
    master, server = ends()
    data = bytearray(master.sealed(message()))
    data[52] ^= 1  # of the wave
    refreshed = Admission(None, **MASTER).sealed(bytes(data))
    data = bytes(data[:-20]) + refreshed[-20:-16] + bytes(data[-16:])
    assert server.judge(data, 0) in (Receipt.FORGED, Receipt.CORRUPTED)
    data = data[:-20] + bytes(4) + data[-16:]  # says that it has no checksum
    assert server.judge(data, 0) is Receipt.FORGED


@pytest.mark.parametrize("others", [1, 1000], ids=["one epoch", "an epoch a packet"])
def test_a_flood_is_refused_and_takes_nothing_from_the_user(others):
    """A flooder ten times too fast beside a user at 125 Hz, for two seconds."""
    _, server = ends(None)
    step_ns = round(1e9 / (10 * LARGEST_RATE_HZ))
    refused = user_refused = 0
    for number in range(round(2e9 / step_ns)):
        now_ns = number * step_ns
        flood = message(number + 1, 1000 + number % others)
        refused += server.judge(flood, now_ns) is Receipt.FLOOD
        if number % 160 == 0:
            user_refused += server.judge(message(number + 1), now_ns) is not None
    assert user_refused == 0
    if others == 1:
        assert refused == pytest.approx(0.9 * 2e9 / step_ns, rel=0.02)


def test_a_replay_of_true_packets_takes_nothing_from_the_user():
    master, server = ends()
    packets = [master.sealed(message(n + 1)) for n in range(250)]
    refused = []
    for n, packet in enumerate(packets):
        refused.append(server.judge(packet, n * 8_000_000))
        for _ in range(20):  # 2.5 kHz of copies
            server.judge(packets[n // 2], n * 8_000_000)
    assert refused == [None] * len(packets)


def test_packets_that_an_outage_held_back_are_no_flood():
    _, server = ends(None)
    assert all(server.judge(message(n + 1), 0) is None for n in range(BURST))
    assert server.judge(message(BURST + 1), 0) is Receipt.FLOOD


def test_a_token_file_is_readable_by_its_owner_only_and_read_back(tmp_path):
    """Whatever files are by default."""
    key = Token.of_session(secrets.token_bytes(32))
    for name, token in (("server", key), ("user1", key.of("user1"))):
        path = tmp_path / name
        before = os.umask(0)
        write_token(path, token)
        os.umask(before)
        assert stat.S_IMODE(os.stat(path).st_mode) == 0o600
        assert read_token(path) == token
        with pytest.raises(ParameterError, match="File exists"):
            write_token(path, token)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no session token"),
        ('{"session": "zz", "user": "user1", "key": "1"}', "holds no session token"),
        ("[1]", "holds no session token"),
        (None, "No such file"),
    ],
)
def test_a_file_that_is_no_token_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "file"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ParameterError, match=words):
        read_token(path)


def test_a_session_has_a_file_for_the_server_and_one_for_each_user(tmp_path, capsys):
    assert main(["token", str(tmp_path / "keys"), "user1", "user2"]) == 0
    key, *users = (read_token(path) for path in capsys.readouterr().out.split())
    assert users == [key.of("user1"), key.of("user2")]
    assert stat.S_IMODE(os.stat(tmp_path / "keys").st_mode) == 0o700


@pytest.mark.parametrize(
    ("users", "text"),
    [
        (["user1", "user1"], "users = user1, user1: must be different names"),
        (["server"], "and not server"),
        (["../user1"], "letters, digits"),
        (["user3"], "user3: there already"),
    ],
)
def test_wrong_users_and_old_files_are_refused_in_one_message(tmp_path, capsys, users, text):
    (tmp_path / "user3").write_text("old")
    assert main(["token", str(tmp_path), *users]) == 2
    assert text in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["user3"]
