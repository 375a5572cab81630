# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Design of anti-aliasing and velocity filters, and their worst-case gains."""
