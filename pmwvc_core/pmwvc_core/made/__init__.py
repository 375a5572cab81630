# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws made from scenarios: what each starts from, and what it goes by."""
