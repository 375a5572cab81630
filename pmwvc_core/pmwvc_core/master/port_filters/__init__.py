# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filters between a device and its wave port: velocity filter, filter bank, local models."""
