# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The course in ``docs/course``: its runs, numbers, pictures and pages."""
