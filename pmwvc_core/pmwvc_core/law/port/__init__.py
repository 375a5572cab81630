# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ports of a device: masters of both channels, filters around them, position feedback."""
