# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a test with real nodes may claim only of a machine that does not stand still: where it
does, the test is run again with sessions of its own, twice at most, counted, and then fails.
"""

import contextlib

import pytest
from _pytest.runner import runtestprotocol

MOST = 3  # runs of a test
STALLED = pytest.StashKey[str]()


class Stalled(AssertionError):
    """A claim failed while the machine stood still."""


@contextlib.contextmanager
def unless_stalled(stalled):
    """Have claims fail as :class:`Stalled` where ``stalled()`` is true."""
    try:
        yield
    except AssertionError as error:
        if stalled():
            raise Stalled(f"the machine stood still: {error}") from error
        raise


def pytest_runtest_makereport(item, call):
    """Note that a test stalled."""
    if call.excinfo is not None and call.excinfo.errisinstance(Stalled):
        item.stash[STALLED] = str(call.excinfo.value)


def pytest_runtest_protocol(item, nextitem):
    """Run a test again that stalled; also the sessions that others read are made anew."""
    if item.get_closest_marker("integration") is None:  # pytest asks for every test
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for left in reversed(range(MOST)):
        item.stash[STALLED] = ""
        reports = runtestprotocol(item, log=False, nextitem=nextitem)
        if not item.stash[STALLED] or not left:
            break
        item.warn(pytest.PytestWarning(f"run again ({left} left): {item.stash[STALLED]}"))
        item.session._setupstate.teardown_exact(None)
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
