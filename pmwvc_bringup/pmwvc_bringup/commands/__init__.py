# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands of ``pmwvc``: one module each, with its record ``COMMAND``, in any room."""
