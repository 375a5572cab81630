# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and verdicts from the traces of a session; no drawing, no files."""
