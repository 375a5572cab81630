# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The scenarios of the project on the plain channel, whatever their files say: for tests about
what only that channel has (filter, rate drop, hold), or whose numbers are those of its lag.
Otherwise as :mod:`pmwvc_bringup.scenarios`.
"""

from pmwvc_bringup import scenarios
from pmwvc_bringup.scenarios import known, settings, to_yaml

__all__ = ["known", "load", "settings", "to_yaml"]


def load(name, *, settings_texts=(), **options):
    """Return a scenario by name; settings may choose the channel again."""
    return scenarios.load(name, settings_texts=["channel=plain", *settings_texts], **options)
