# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals of a session as tables, and the files of other tools that hold them."""
