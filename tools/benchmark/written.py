# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a study as tables, a picture, and files with every session and grid of walls."""

import csv
import dataclasses
import io
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmark.better import BETTER, counted, listed, words
from benchmark.columns import (
    OF_TASK,
    OF_WALLS,
    RELEASED,
    Column,
    Rows,
    failed,
    median_of,
    number,
    restless,
    troubled,
)
from benchmark.drawn import PICTURE, picture
from benchmark.intervals import Interval
from benchmark.study import HELD_OUT_SEED, INTERPRETED_SEEDS, OURS, Study
from benchmark.trial import Outcome
from benchmark.walls import Walls
from pmwvc_analysis.charts import chart_files
from pmwvc_core.words import count

PAGE, SESSIONS, WALLS = "benchmark_results.md", "sessions.csv", "walls.csv"
MEDIANS, LISTED = "benchmark_results.csv", "benchmark_better.csv"
CHOSEN = "benchmark_settings.csv"
IMAGES = "images"
HEAD = """# Results of the benchmark

Tasks, methods and columns: [benchmark](benchmark.md). Written by {origin}.

"""

NOT_BEST = """## Where `{ours}` is not the best

{counted} Better: the median on a network, by more than {better:g} % and by a noticeable amount
([benchmark](benchmark.md#tasks-and-search)). [benchmark_better.csv](benchmark_better.csv) has them
all, with both medians and the reasons. The table counts networks, by the best other method and by
reason. Reasons are other numbers of the same sessions that differ by 10 % or more in the same
sense; they are no proof:

* *fails*: sessions of `{ours}` fail. *energy*: the other method generates energy in more than a
  fifth of its sessions. *contact force*: its contact force is smaller, and so is any error of it.
* *lag*: its avatar follows sooner in free motion. *force error less lag*: only the delay makes the
  difference. *b*: the chosen wave impedances differ. *defaults*: `{ours}` is better with its
  default settings."""


def write(study: Study, folder: Path, origin: str) -> None:
    """Write page, picture and sessions into a folder, made if missing."""
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    (folder / PAGE).write_text(page(study, origin), "utf-8")
    (folder / MEDIANS).write_text(medians(study), "utf-8")
    (folder / LISTED).write_text(listed(study), "utf-8")
    (folder / CHOSEN).write_text(chosen(study), "utf-8")
    (folder / SESSIONS).write_text(sessions(study), "utf-8")
    (folder / WALLS).write_text(grids(study), "utf-8")
    chart_files.write(picture(study), folder / IMAGES)


def page(study: Study, origin: str) -> str:
    """Return tables, picture, and where others are better."""
    chart = picture(study)
    image = f"![{chart.heading}]({IMAGES}/{PICTURE}.svg)\n\n{chart.caption}"
    others = NOT_BEST.format(ours=OURS, counted=counted(study), better=100.0 * BETTER)
    head = HEAD.format(origin=origin)
    return f"{head}{conditions(study)}\n\n{table(study)}\n{image}\n\n{others}\n\n{words(study)}"


def conditions(study: Study) -> str:
    """Return what was run, in words."""
    plan, first = study.plan, study.seed + HELD_OUT_SEED
    fewer = [f"`{name}` {each}" for name, each in study.tried.items() if each < plan.candidates]
    seeds = count(INTERPRETED_SEEDS, "seed")
    of_fewer = f" ({', '.join(fewer)}: interpreted, judged with {seeds})" if fewer else ""
    return (
        "Medians; a failed session is an infinite error. "
        "[benchmark_results.csv](benchmark_results.csv) has more columns, and 95 % intervals. "
        "Settings were searched on "
        f"{', '.join(plan.training)}: {plan.candidates} settings for each method{of_fewer}, "
        f"{count(plan.training_seeds, 'seed')}, one setting for all networks and delays. Judged "
        f"on {len(study.held_out)} other networks ({count(plan.seeds, 'seed')} from {first} on; "
        f"seed {study.seed})."
    )


def table(study: Study) -> str:
    """Return the tables over the held-out networks."""
    lines = []
    for task in study.plan.tasks:
        columns = [each for each in OF_TASK[task] if each.compared or each is RELEASED]
        shares = [f"{name} [%]" for name in ("failed", "restless", "not passive")]
        lines += [f"## {task}", "", *_head(["method", *shares, *(e.label for e in columns)])]
        for method in study.plan.methods:
            rows = study.of(method, task, study.held_out)
            lines.append(_row([f"`{method}`", *_shares(rows), *_medians(rows, columns)]))
        failures = _failures(study, task)
        lines += ["", *([failures, ""] if failures else [])]
    walled = [name for name in study.held_out if name in study.plan.walled]
    if walled:
        head = ["method", *(each.label for each in OF_WALLS)]
        lines += ["## walls", "", *_head(head)]
        for method in study.plan.methods:
            cells = _medians(study.rendered(method, walled), OF_WALLS)
            lines.append(_row([f"`{method}`", *cells]))
        lines.append("")
    return "\n".join([*lines, f"[{CHOSEN}]({CHOSEN}) has the settings of each method.", ""])


def chosen(study: Study) -> str:
    """Return the settings of each method, as CSV."""
    lines = [f"{name},{' '.join(settings)}" for name, settings in study.chosen.items()]
    return "\n".join(["method,settings", *lines]) + "\n"


def _shares(rows: Rows) -> list[str]:
    flat = [one for row in rows for one in row]
    active = sum(one.passive is False for one in flat) / len(flat)
    return [number(100.0 * each) for each in (failed(rows).value, restless(rows).value, active)]


def _medians(rows: Rows, columns: Sequence[Column]) -> list[str]:
    return [number(each.factor * median_of(rows, each).value) for each in columns]


def _failures(study: Study, task: str) -> str:
    """Return the kinds of failures, the most frequent first, with the numbers of the others."""
    found: dict[str, dict[str, int]] = {}
    for method in study.plan.methods:
        flat = [one for row in study.of(method, task, study.held_out) for one in row]
        for kind, times in Counter(one.failure for one in flat if one.failure).most_common():
            found.setdefault(kind, {})[f"`{method}`"] = times
    kinds = sorted(found, key=lambda kind: -sum(found[kind].values()))
    others = [
        f"{kind} ({', '.join(f'{name} {times}' for name, times in found[kind].items())})"
        for kind in kinds[1:]
    ]
    also = f"; also {', '.join(others)}" if others else ""
    return f"Failures: {kinds[0]}{also}." if kinds else ""


def medians(study: Study) -> str:
    """Return the medians over the held-out networks with their intervals, as CSV."""
    lines = ["task,method,measure,median,low,high"]
    walled = [name for name in study.held_out if name in study.plan.walled]
    for method in study.plan.methods:
        for task in study.plan.tasks:
            rows: Rows = study.of(method, task, study.held_out)
            for label, of in (("failed [%]", failed), ("failed or restless [%]", troubled)):
                lines.append(",".join((task, method, label, *_percent(of(rows)))))
            lines += _lines(task, method, rows, OF_TASK[task])
        if walled:
            lines += _lines("walls", method, study.rendered(method, walled), OF_WALLS)
    return "\n".join(lines) + "\n"


def _percent(found: Interval) -> list[str]:
    return [number(100.0 * each) for each in found]


def _lines(task: str, method: str, rows: Rows, columns: Sequence[Column]) -> list[str]:
    return [
        ",".join(
            (
                task,
                method,
                one.label,
                *(number(one.factor * each) for each in median_of(rows, one)),
            )
        )
        for one in columns
    ]


def sessions(study: Study) -> str:
    """Return every session that judges, as CSV: all that is needed to run it again."""
    return _file(study, study.judged.items(), ("task", "network", "seed", "duration_s"), Outcome)


def grids(study: Study) -> str:
    """Return every grid of walls likewise."""
    return _file(study, study.walled.items(), ("network", "seed"), Walls)


def _file(
    study: Study, found: Iterable[tuple[Any, Any]], given: Sequence[str], kind: type[Any]
) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = [field.name for field in dataclasses.fields(kind)]
    writer.writerow(["method", *given, "held_out", "settings", *names])
    for item, result in found:
        held_out, settings = item.network in study.held_out, " ".join(item.settings)
        numbers = [text_of(getattr(result, name)) for name in names]
        of = [text_of(getattr(item, name)) for name in given]
        writer.writerow([item.method, *of, held_out, settings, *numbers])
    return stream.getvalue()


def text_of(value: object) -> str:
    """Return a number of a result with every bit; empty: not known."""
    if isinstance(value, float):
        return repr(value)
    return "" if value is None else str(value)


def _head(cells: list[str]) -> list[str]:
    return [_row(cells), "|---" * len(cells) + "|"]


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"
