# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The layout of a session folder: topics, message definitions, metadata, size on disk."""
