# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The starter of a launched session: starts its nodes together, and ends when its time is over.

::

    python -m pmwvc_bringup.session.starter FOLDER/scenario.yaml --duration 20 --namespace /lab

For the launch file: its nodes wait for their ``start`` service. When the graph shows both ends of
every topic and each node says that it has matched the others, the emulator, the server and then
the masters are started; the time counts from the first ticks of all masters.
Exit code 0: the time is over; 2: the nodes were not connected in time.
"""

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path


def main(args: Sequence[str] | None = None) -> int:
    """Run the starter and return its exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):  # also while the rest is imported
        signal.signal(number, lambda *_: sys.exit(0))
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
    nodes = plan.nodes(scenario, folder=Path(given.scenario).parent, paused=True)
    there = [n for n in nodes if not (given.unrecorded and n.kind == "recorder")]
    names = [f"{prefix}{node.ros_name}" for node in there]
    groups = [[f"{prefix}{name}" for name in group] for group in plan.start_order(nodes)]
    with watching([user.name for user in scenario.users], namespace=namespace) as monitor:
        try:
            monitor.begin(names, ends, groups)
        except PmwvcError as error:
            print(f"starter: {error}", flush=True)
            return 2
    print("starter: the session begins", flush=True)
    time.sleep(given.duration)
    return 0


if __name__ == "__main__":
    sys.exit(main())
