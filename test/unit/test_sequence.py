# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of messages, and what is missing between them."""

from hypothesis import given
from hypothesis import strategies as st

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.own import Decoded, Series


def gaps(numbers):
    return Series(schemas.WAVE, [Decoded(0, None, *each) for each in numbers]).gaps()


@given(st.lists(st.integers(1, 60), min_size=1, max_size=60, unique=True))
def test_gaps_are_what_is_not_there(numbers):
    absent = {*range(1, max(numbers) + 1)} - {*numbers}
    assert gaps(("a", number) for number in numbers) == {"a": (len(absent), len({*numbers}))}


def test_publishers_are_counted_apart():
    found = gaps((f"{epoch}", seq) for epoch, seq in ((1, 1), (1, 3), (2, 1), (2, 2)))
    assert found == {"1": (1, 2), "2": (0, 2)}
