# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Outages of other lengths, ways, grips and delays in a carry, ``docs/outages.md`` and
``docs/outages.csv``: ``python -m faults.outages``.
"""

import itertools
import os
from multiprocessing import Pool
from pathlib import Path
from typing import NamedTuple

from faults.sessions import DAMPED_S, PEAK, Carried
from pmwvc_analysis.traces.thresholds import BLOW_N
from pmwvc_core.law.channel.constants import OUTAGE_S

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE, TABLE = DOCS / "outages.md", DOCS / "outages.csv"
BEGIN_S, FRAME_S = 6.0, 0.008
LENGTHS_S = (0.05, 0.3, 0.8, 2.0, 4.0)
WAYS = {"both": "link", "up": "link.up", "down": "link.down"}
DELAYS_S = (0.005, 0.016, 0.05, 0.1)
SQUEEZES_N = (1.0, 2.0, 3.0, 4.0)  # the device renders 3.3 N at most
TITLES = (
    *("delay [ms]", "grip [N]", "none [mm]", "allowed [mm]"),
    *(f"{length_s:g} s" for length_s in LENGTHS_S),
    *("peak", "step [N]", "half [ms]", "damping [ms]"),
)
NAMES = (
    *("delay_ms", "grip_n", "lost", "none_mm", "allowed_least_mm", "allowed_most_mm"),
    *(f"{name}_{length_s:g}_s_mm" for length_s in LENGTHS_S for name in ("soon", "late")),
    *("peak", "step_n", "half_ms", "damping_one_ms", "damping_both_ms"),
)
HEAD = """# Outages

Two hands carry a cube (`carry_16ms`, strict channel, device limited to 3.3 N). No packets pass for
0.05 to 4 s from the middle of the first move on: uplinks, downlinks or both. Each row is the worst
of the three; [outages.csv](outages.csv) has them separately.
`PYTHONPATH=tools .venv/bin/python -m faults.outages` writes both (minutes).

* *None*: offset of device and avatar without an outage. *0.05 s* to *4 s*: largest offset [mm] in
  the second that begins one second after an outage of that length. *Allowed*:
  F (T1 + T2)/(2b) + 1 mm, F at the end, T1 and T2 of the undisturbed link. In the second that
  begins three seconds after, {late} of {outages} offsets are within it.
* *Peak*: largest force over the undisturbed session's (allowed {peak:g}). *Step*: largest change
  of force within 1 ms (from {step:g} N on felt as a blow). *Half*: time with less than half of the
  undisturbed force.
* *Damping*: time from the last packet sent until all devices and avatars have only damping
  (allowed {damped:g} ms), of outages longer than {concealed:g} ms; shorter ones are concealed.

Bold: more than allowed. Every port was passive in {passive} of {count} sessions.

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
    damped_s = session.damped_s(begin_s) if length_s >= OUTAGE_S else (0.0, 0.0)
    users = session.summary["users"]
    step_n = max(user["force_step_max_n"] for user in users)
    below_half_s = max(user["dropout_s"] or 0.0 for user in users)
    forces = session.peak_n, step_n, below_half_s
    return Seen(soon_m, late_m, session.bound_m(), *forces, damped_s, session.passive)


Tried = tuple[Seen, list[Seen]]  # without an outage, and with those of all lengths


def row(delay_s: float, squeeze_n: float, ways: list[Tried]) -> str:
    """Return the row of a delay and a grip: the worst of the directions lost."""
    calm = [each for each, _ in ways]
    offsets = [
        _marked(1e3 * max(e.soon_m for e in seen), all(e.soon_m <= e.allowed_m for e in seen))
        for seen in zip(*(lengths for _, lengths in ways), strict=True)
    ]
    allowed = [1e3 * each.allowed_m for _, lengths in ways for each in lengths]
    numbers = [worst(each) for each in ways]
    peak, step_n, half_s, _, damped_s = (max(each) for each in zip(*numbers, strict=True))
    cells = [
        f"{1e3 * delay_s:g}",
        f"{squeeze_n:g}",
        _marked(1e3 * max(e.late_m for e in calm), all(e.late_m <= e.allowed_m for e in calm)),
        " to ".join(dict.fromkeys(f"{mm:.1f}" for mm in (min(allowed), max(allowed)))),
        *offsets,
        _marked(peak, peak <= PEAK, digits=2),
        f"{step_n:.2f}",
        f"{1e3 * half_s:.0f}",
        _marked(1e3 * damped_s, damped_s <= DAMPED_S, digits=0),
    ]
    return f"| {' | '.join(cells)} |"


def line(grip: tuple[float, float, str], tried_: Tried) -> str:
    """Return the line of a delay, a grip and the direction lost, as CSV."""
    calm, seen = tried_
    allowed = [1e3 * each.allowed_m for each in seen]
    peak, step_n, half_s, *damped_s = worst(tried_)
    millimetres = [1e3 * m for each in seen for m in (each.soon_m, each.late_m)]
    cells = [
        *(f"{1e3 * grip[0]:g}", f"{grip[1]:g}", grip[2]),
        *(f"{mm:.1f}" for mm in (1e3 * calm.late_m, min(allowed), max(allowed), *millimetres)),
        *(f"{peak:.2f}", f"{step_n:.2f}"),
        *(f"{1e3 * time_s:.0f}" for time_s in (half_s, *damped_s)),
    ]
    return ",".join(cells)


def worst(tried_: Tried) -> tuple[float, ...]:
    """Return peak, step [N], time below half, to damping at one end and at both [s]: the worst
    over all lengths.
    """
    calm, seen = tried_
    return (
        max(each.peak_n for each in seen) / calm.peak_n,
        max(each.step_n for each in seen),
        max(each.below_half_s for each in seen),
        *(max(times) for times in zip(*(each.damped_s for each in seen), strict=True)),
    )


def _marked(number: float, held: bool, *, digits: int = 1) -> str:
    text = f"{number:.{digits}f}"
    return text if held else f"**{text}**"


def main() -> None:
    """Try all, write the page."""
    grips = list(itertools.product(DELAYS_S, SQUEEZES_N, WAYS))
    cases = [Case(*grip, length_s) for grip in grips for length_s in (0.0, *LENGTHS_S)]
    with Pool(os.cpu_count()) as pool:
        seen = dict(zip(cases, pool.map(tried, cases, chunksize=3), strict=True))
    found = {
        grip: (seen[Case(*grip, 0.0)], [seen[Case(*grip, length_s)] for length_s in LENGTHS_S])
        for grip in grips
    }
    TABLE.write_text("\n".join([",".join(NAMES), *(line(*each) for each in found.items())]) + "\n")
    rows = [
        row(delay_s, squeeze_n, [found[delay_s, squeeze_n, way] for way in WAYS])
        for delay_s, squeeze_n in itertools.product(DELAYS_S, SQUEEZES_N)
    ]
    PAGE.write_text(page(rows, seen), "utf-8")


def page(rows: list[str], seen: dict[Case, Seen]) -> str:
    """Return the text of the page."""
    limits = {"peak": PEAK, "step": BLOW_N, "damped": 1e3 * DAMPED_S, "concealed": 1e3 * OUTAGE_S}
    late = [each.late_m <= each.allowed_m for case, each in seen.items() if case.length_s]
    counts = {"late": sum(late), "outages": len(late), "count": len(seen)}
    head = HEAD.format(**limits, **counts, passive=sum(each.passive for each in seen.values()))
    return (
        "\n".join([head + f"| {' | '.join(TITLES)} |", "|---" * len(TITLES) + "|", *rows]) + "\n"
    )


if __name__ == "__main__":
    main()
