# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Outages of other lengths, ways, grips and delays in a carry, and ``docs/outages.md``:
``python -m faults.outages``.
"""

import itertools
import os
from multiprocessing import Pool
from pathlib import Path
from typing import NamedTuple

from faults.sessions import PEAK, Carried
from pmwvc_analysis.traces.felt import BLOW_N

PAGE = Path(__file__).resolve().parents[2] / "docs" / "outages.md"
BEGIN_S, FRAME_S = 6.0, 0.008
LENGTHS_S = (0.05, 0.3, 0.8, 2.0, 4.0)
WAYS = {"both": "link", "up": "link.up", "down": "link.down"}
DELAYS_S = (0.005, 0.016, 0.05, 0.1)
SQUEEZES_N = (1.0, 2.0, 3.0, 4.0)  # the device renders 3.3 N at most
TITLES = ("delay [ms]", "grip [N]", "lost", "none", "allowed")
HEAD = """# Outages

Two hands carry a cube (`carry_16ms`, strict channel, device limited to 3.3 N). No packets pass for
0.05 to 4 s from the middle of the first move on, 6 s after the first packet of each direction.
`PYTHONPATH=tools .venv/bin/python -m faults.outages` writes this page (minutes).

* *Lost*: uplinks, downlinks or both. *None*: offset of device and avatar without an outage [mm].
* *0.05 s* to *4 s*: largest offset in the second that begins one/three seconds after an
  outage of that length [mm]. *Allowed*: F (T1 + T2)/(2b) + 1 mm, F at the end, T1 and T2 of the
  undisturbed link.
* *Peak*: largest force over the undisturbed session's (allowed {peak:g}). *Step*: largest change
  of force within 1 ms (from {step:g} N on felt as a blow). *Half*: time with less than half of the
  undisturbed force.
* *Damping*: time until one end (all devices or all avatars) has only damping/until both have,
  from the last packet sent (*both*: the last downlink packet); allowed 100 ms. If one direction is
  lost, the receiving end learns it from the other end, one delay later.

Peak, step, half and damping are the worst over all lengths. Bold: more than allowed. Every port
was passive in {passive} of {count} sessions.

| {titles} | peak | step [N] | half [ms] | damping [ms] |
|{rule}|---|---|---|---|
"""


class Case(NamedTuple):
    """An outage of a length [s] on some ways, under a squeeze [N]; length 0: none."""

    delay_s: float
    squeeze_n: float
    way: str
    length_s: float


class Seen(NamedTuple):
    """What came of a case: distances one and three seconds after, and allowed [m]; peak and
    largest step [N]; time below half of the force [s];
    time to damping at one of the ends and at both [s]; whether all ports are passive.
    """

    soon_m: float
    late_m: float
    allowed_m: float
    peak_n: float
    step_n: float
    below_half_s: float
    damped_s: tuple[float, float]
    passive: bool


def tried(case: Case) -> Seen:
    """Simulate a case."""
    delay_s, squeeze_n, way, length_s = case
    later_s = 0.0 if way == "up" else delay_s + FRAME_S  # of the first packet down
    begin_s, end_s = BEGIN_S + later_s, BEGIN_S + later_s + length_s
    settings = [f"link.delay_s={delay_s:g}", f"operator.squeeze={squeeze_n:g}"]
    if length_s:
        settings.append(f"{WAYS[way]}.schedule={BEGIN_S:g} outage; {BEGIN_S + length_s:g} base")
    session = Carried((*settings, f"duration_s={end_s + 4.0:g}"))
    soon_m, late_m = (session.offset_m(end_s + k, end_s + k + 1.0) for k in (1.0, 3.0))
    damped_s = session.damped_s(begin_s) if length_s else (0.0, 0.0)
    users = session.summary["users"]
    step_n = max(user["force_step_max_n"] for user in users)
    below_half_s = max(user["dropout_s"] or 0.0 for user in users)
    forces = session.peak_n, step_n, below_half_s
    return Seen(soon_m, late_m, session.bound_m(), *forces, damped_s, session.passive)


def row(grip: tuple[float, float, str], calm: Seen, seen: list[Seen]) -> str:
    """Return the row of a delay, a squeeze and ways."""
    pairs = [
        "/".join(_marked(1e3 * m, m <= each.allowed_m) for m in (each.soon_m, each.late_m))
        for each in seen
    ]
    least_m, most_m = min(e.allowed_m for e in seen), max(e.allowed_m for e in seen)
    peak = max(each.peak_n for each in seen) / calm.peak_n
    step_n = max(each.step_n for each in seen)
    damped_s = [max(times) for times in zip(*(each.damped_s for each in seen), strict=True)]
    cells = [
        f"{1e3 * grip[0]:g}",
        f"{grip[1]:g}",
        grip[2],
        _marked(1e3 * calm.late_m, calm.late_m <= calm.allowed_m),
        " to ".join(dict.fromkeys(f"{1e3 * m:.1f}" for m in (least_m, most_m))),
        *pairs,
        _marked(peak, peak <= PEAK, digits=2),
        f"{step_n:.2f}",
        f"{1e3 * max(each.below_half_s for each in seen):.0f}",
        "/".join(_marked(1e3 * one_s, one_s <= 0.1, digits=0) for one_s in damped_s),
    ]
    return f"| {' | '.join(cells)} |"


def _marked(number: float, held: bool, *, digits: int = 1) -> str:
    text = f"{number:.{digits}f}"
    return text if held else f"**{text}**"


def main() -> None:
    """Try all, write the page."""
    grips = list(itertools.product(DELAYS_S, SQUEEZES_N, WAYS))
    cases = [Case(*grip, length_s) for grip in grips for length_s in (0.0, *LENGTHS_S)]
    with Pool(os.cpu_count()) as pool:
        seen = dict(zip(cases, pool.map(tried, cases, chunksize=3), strict=True))
    rows = [
        row(grip, seen[Case(*grip, 0.0)], [seen[Case(*grip, length_s)] for length_s in LENGTHS_S])
        for grip in grips
    ]
    head = HEAD.format(
        peak=PEAK,
        step=BLOW_N,
        passive=sum(each.passive for each in seen.values()),
        count=len(seen),
        titles=" | ".join((*TITLES, *(f"{length_s:g} s" for length_s in LENGTHS_S))),
        rule="|".join("---" for _ in (*TITLES, *LENGTHS_S)),
    )
    PAGE.write_text(head + "\n".join(rows) + "\n", "utf-8")


if __name__ == "__main__":
    main()
