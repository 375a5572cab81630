# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a study as tables, a picture, and files with every session and probe."""

import csv
import dataclasses
import io
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmark.better import BETTER, OURS, words
from benchmark.columns import (
    ERRORS,
    OF_PROBE,
    OF_SESSION,
    Column,
    failed,
    median_of,
    restless,
)
from benchmark.drawn import PICTURE, picture
from benchmark.intervals import Interval
from benchmark.probe import Rendered
from benchmark.study import HELD_OUT_SEED, Study
from benchmark.trial import Outcome
from pmwvc_analysis.charts import chart_files
from pmwvc_core.words import count

PAGE, SESSIONS, PROBES = "benchmark_results.md", "sessions.csv", "probes.csv"
MEDIANS = "benchmark_results.csv"
IMAGES = "images"
ROUNDING = 1e-9  # in the unit of the column: shown as 0
HEAD = """# Results of the benchmark

Task, methods and columns: [benchmark](benchmark.md). Written by {origin}.

"""


def write(study: Study, folder: Path, origin: str) -> None:
    """Write page, picture and sessions into a folder, made if missing."""
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    (folder / PAGE).write_text(page(study, origin), "utf-8")
    (folder / MEDIANS).write_text(medians(study), "utf-8")
    (folder / SESSIONS).write_text(sessions(study), "utf-8")
    (folder / PROBES).write_text(probes(study), "utf-8")
    chart_files.write(picture(study), folder / IMAGES)


def page(study: Study, origin: str) -> str:
    """Return tables, picture, and where others are better."""
    chart = picture(study)
    head = HEAD.format(origin=origin)
    image = f"![{chart.heading}]({IMAGES}/{PICTURE}.svg)\n\n{chart.caption}"
    others = (
        "## Where another method is better\n\nNumber of networks on which the median is better "
        f"than that of `{OURS}` by more than {100.0 * BETTER:g} %, of {len(study.held_out)} "
        f"({len(study.probed_on)} for impedance, walls and completion time). Then the clearest "
        f"case, in brackets `{OURS}` there.\n"
    )
    return f"{head}{table(study)}\n{image}\n\n{others}\n{words(study)}"


def table(study: Study) -> str:
    """Return the tables over the held-out networks, what was run, and the settings chosen."""
    plan = study.plan
    head = [
        "method",
        "failed",
        "restless",
        "not passive",
        *(column.label for column in ERRORS),
        "failures",
    ]
    lines = [_row(head), _row(["---"] * len(head))]
    for method in plan.methods:
        outcomes = study.of(method, study.held_out)
        flat = [outcome for row in outcomes for outcome in row]
        cells = [
            _cell(failed(outcomes), 100.0, " %"),
            _cell(restless(outcomes), 100.0, " %"),
            f"{sum(one.passive is False for one in flat)} of {len(flat)}",
            *(_cell(median_of(outcomes, column), column.factor, "") for column in ERRORS),
        ]
        kinds = Counter(one.failure for one in flat if one.failure).most_common()
        cells.append(", ".join(f"{number} {kind}" for kind, number in kinds) or "-")
        lines.append(_row([f"`{method}`", *cells]))
    lines += ["", *_medians(study, OF_SESSION)]
    lines += ["", *_medians(study, OF_PROBE)] if study.probed_on else []
    first = study.seed + HELD_OUT_SEED
    sizes = (
        "Medians ([benchmark_results.csv](benchmark_results.csv) has their 95 % intervals); a "
        "failed session is an infinite error. Settings "
        f"were searched on {', '.join(plan.training)} ({plan.candidates} settings for each "
        f"method, {count(plan.training_seeds, 'seed')}) and judged on {len(study.held_out)} other "
        f"networks ({count(plan.seeds, 'seed')} from {first} on, {plan.duration_s:g} s a session; "
        f"seed {study.seed}). Probes: {count(len(study.probed_on), 'network')} of these, "
        f"{count(plan.probes, 'seed')}, {plan.hold_s:g} s of hold: {', '.join(study.probed_on)}."
    )
    chosen = [f"- `{name}`: `{' '.join(each)}`" for name, each in study.chosen.items()]
    return "\n".join([sizes, "", *lines, "", "Chosen settings:", "", *chosen, ""])


def _medians(study: Study, columns: Sequence[Column]) -> list[str]:
    """Return the lines of a table of medians of sessions and probes."""
    lines = [
        _row(["method", *(each.label for each in columns)]),
        _row(["---"] * (len(columns) + 1)),
    ]
    for method in study.plan.methods:
        cells = [_number(each.factor * _median(study, method, each).value) for each in columns]
        lines.append(_row([f"`{method}`", *cells]))
    return lines


def medians(study: Study) -> str:
    """Return the medians of sessions and probes with their intervals, as CSV."""
    lines = ["method,measure,median,low,high"]
    for method in study.plan.methods:
        for column in (*OF_SESSION, *(OF_PROBE if study.probed_on else ())):
            numbers = [_number(column.factor * each) for each in _median(study, method, column)]
            lines.append(",".join((method, column.label, *numbers)))
    return "\n".join(lines) + "\n"


def _median(study: Study, method: str, column: Column) -> Interval:
    rows = study.of if column in OF_SESSION else study.measured
    return median_of(rows(method, _asked(study, column)), column)


def _asked(study: Study, column: Column) -> list[str]:
    """Return the networks that count in a column."""
    return [
        network
        for network in (study.held_out if column in OF_SESSION else study.probed_on)
        if not column.asked
        or any(
            math.isfinite(getattr(one, column.name))
            for method in study.plan.methods
            for one in study.measured(method, [network])[0]
        )
    ]


def sessions(study: Study) -> str:
    """Return every session that judges, as CSV: all that is needed to run it again."""
    return _file(study, study.judged.items(), "duration_s", Outcome)


def probes(study: Study) -> str:
    """Return every probe likewise."""
    return _file(study, study.probed.items(), "hold_s", Rendered)


def _file(study: Study, found: Iterable[tuple[Any, Any]], length: str, kind: type[Any]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = [field.name for field in dataclasses.fields(kind)]
    writer.writerow(["method", "network", "held_out", "seed", "settings", length, *names])
    for item, result in found:
        held_out = item.network in study.held_out
        row = [item.method, item.network, held_out, item.seed, " ".join(item.settings)]
        numbers = [text_of(getattr(result, name)) for name in names]
        writer.writerow([*row, text_of(getattr(item, length)), *numbers])
    return stream.getvalue()


def _cell(found: Interval, factor: float, unit: str) -> str:
    return f"{_number(found[0] * factor)}{unit}"


def _number(value: float) -> str:
    if math.isnan(value):
        return "unknown"
    if abs(value) < ROUNDING:
        return "0"
    return f"{value:.3g}" if math.isfinite(value) else "fails"


def text_of(value: object) -> str:
    """Return a number of a result with every bit; empty: not known."""
    if isinstance(value, float):
        return repr(value)
    return "" if value is None else str(value)


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"
