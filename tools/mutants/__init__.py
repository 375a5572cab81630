# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``make mutants``: small defects put into the product, to see which of them no test notices."""
