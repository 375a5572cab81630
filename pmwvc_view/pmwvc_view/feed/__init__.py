# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed: traces of all nodes as rows of one time line, and what is judged of them at once."""
