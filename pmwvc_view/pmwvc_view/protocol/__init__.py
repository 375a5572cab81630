# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The protocol between the page and its server; its document, which the page follows, is
docs/view_protocol.md. No input or output here.
"""

VERSION = 1
HEARTBEAT_S = 0.014  # a held target is sent this often, also where it does not move
SILENCE_S = 0.15  # a hand without a target for this long lets go
CREDITS = 8  # snapshots that may be sent and not acknowledged
MESSAGE_BYTES = 4096  # longest message of a page
MESSAGES_HZ = 500.0  # messages of a page: its mean rate, and as many at once
LIMITS = {  # as the session message declares them
    "heartbeat_s": HEARTBEAT_S, "silence_s": SILENCE_S, "credits": CREDITS,
    "message_bytes": MESSAGE_BYTES, "messages_hz": MESSAGES_HZ,
}  # fmt: skip
