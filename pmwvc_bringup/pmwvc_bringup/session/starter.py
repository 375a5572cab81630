# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Starts the nodes of a launched session together, and ends when the session's time is over.

::

    python -m pmwvc_bringup.session.starter FOLDER/scenario.yaml --duration 20 --namespace /lab

For the launch file: its nodes wait for their ``start`` service. When all of them have met, the
emulator, the server and then the masters are started; the time counts from the first ticks of all
masters. Ends with 0 when the time is over, with 2 when the nodes do not meet.
"""

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

MEETING_S = 30.0
BEGINNING_S = 3.0


def main(args: Sequence[str] | None = None) -> int:
    """Run the starter and return its exit code."""
    signal.signal(signal.SIGINT, _leave)  # also while the rest is imported
    signal.signal(signal.SIGTERM, _leave)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("scenario", help="scenario file of the session")
    parser.add_argument("--duration", type=float, default=0.0, help="0: until interrupted [s]")
    parser.add_argument("--namespace", default="", help="namespace of the whole session")
    parser.add_argument("--unrecorded", action="store_true", help="there is no recorder")
    given = parser.parse_args(args)

    from pmwvc_bringup import scenarios
    from pmwvc_bringup.session import plan
    from pmwvc_bringup.session.monitor import watching
    from pmwvc_core.errors import PmwvcError

    scenario = scenarios.load(given.scenario)
    namespace = "/" + given.namespace.strip("/")
    prefix = namespace.rstrip("/")
    ends = plan.topic_ends(scenario, recorded=not given.unrecorded)
    ends = {f"{prefix}{topic}": counts for topic, counts in ends.items()}
    masters = [f"{prefix}/{user.name}/master" for user in scenario.users]
    with watching([user.name for user in scenario.users], namespace=namespace) as monitor:
        until = time.monotonic() + MEETING_S
        while missing := monitor.missing(ends):
            if time.monotonic() > until:
                print(
                    f"starter: the nodes have not found each other within {MEETING_S:g} s: "
                    f"{'; '.join(missing)}",
                    flush=True,
                )
                return 2
            time.sleep(0.02)
        try:
            for names in ([f"{prefix}/netem"], [f"{prefix}/server"], masters):
                monitor.start(names)
        except PmwvcError as error:
            print(f"starter: {error}", flush=True)
            return 2
        until = time.monotonic() + BEGINNING_S
        while not monitor.all_ticking() and time.monotonic() < until:
            time.sleep(0.01)
    print("starter: the session begins", flush=True)
    time.sleep(given.duration)
    return 0


def _leave(_: int, __: FrameType | None) -> NoReturn:
    sys.exit(0)


if __name__ == "__main__":
    sys.exit(main())
