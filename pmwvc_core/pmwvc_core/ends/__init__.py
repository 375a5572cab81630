# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a session as nodes and simulator step them: the pure laws, with the packets of the
network, changes that come from other threads, and the signals that observers see.
"""
