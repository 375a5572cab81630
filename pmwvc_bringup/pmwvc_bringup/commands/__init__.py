# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands of ``pmwvc``: functions decorated with :func:`pmwvc_bringup.command.command`."""
