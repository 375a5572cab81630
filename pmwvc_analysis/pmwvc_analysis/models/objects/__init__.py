# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model of what other packages bring: objects stepped on arrays, one signal per run."""
