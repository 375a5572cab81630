# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions drawn at random say no wrong word, against a judgement written for the test alone; and
summary, terminal, report and page say the same.

Twelve sessions have fixed seeds: of the first 25 those unlike the others.
``PMWVC_CAMPAIGN=300`` draws as many others, from the seed ``PMWVC_CAMPAIGN_FROM`` on.
"""

import html
import os
import re

import numpy as np
import pytest
from support.own_judgement import own_judgement, stepped, wrong_words

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.compare import probes
from pmwvc_analysis.report.report import render
from pmwvc_analysis.transparency.transparency import Rendering
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup.scenarios import find, read
from pmwvc_bringup.session.terminal import verdict_lines
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_view.simulated import SimulatedSession

DRAWN = int(os.environ.get("PMWVC_CAMPAIGN", "0"))
FIRST = int(os.environ.get("PMWVC_CAMPAIGN_FROM", "1000"))
# Controller, channel, scenario, hand, coupling and changes of each are those of others; in 10 the
# filters of its scenario have no part.
ALIKE = {0, 2, 3, 7, 8, 10, 13, 14, 17, 19, 20, 22, 23}
SEEDS = range(FIRST, FIRST + DRAWN) if DRAWN else sorted({*range(25)} - ALIKE)
SNAPSHOT_S = 0.016
PAGE_EVERY = 1 if DRAWN else 5  # sessions of which the page is looked at
OPERATORS = ("hand", "hand", "constant", "sinusoid", "chirp", "force", "motion", "motion", "none")
SCENARIOS = (
    "carry_16ms", "carry_16ms", "wall", "wall", "cube_3d", "active_wall", "wall_slow",
    "three_users", "playback", "wall_local_model", "stiff_24ms", "degrading",
)  # fmt: skip
PLACES = (
    "wall", "wall_with_slope", "wall_with_impedance", "cube_with_impedance", "hunt_crossley",
    "hunt_crossley_with_impedance", "active_wall",
)  # fmt: skip
PRESETS = ("lan", "transatlantic", "wifi_good", "wifi_campus", "lte", "leo", "geo", "torture")
CHANGES = (
    "2 server.contact_stiffness=3000", "2 link.delay_s=0.05", "2 safety.max_force=2",
    "2 master.impedance=60", "2 link.loss=0.4; 3 link.loss=0",
)  # fmt: skip


class Draw:
    """Draws settings from one generator."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)
        self.settings = {}

    def one_of(self, *values):
        return values[int(self._rng.integers(len(values)))]

    def happens(self, probability):
        return self._rng.random() < probability

    def between(self, low, high):
        return float(f"{self._rng.uniform(low, high):.3g}")

    def scale(self, low, high):
        return float(f"{np.exp(self._rng.uniform(np.log(low), np.log(high))):.3g}")

    def maybe(self, probability, **values):
        if self.happens(probability):
            self.settings |= {name.replace("__", "."): value for name, value in values.items()}


def network(d):
    if d.happens(0.6):
        d.maybe(1.0, link__delay_s=d.one_of(0.0, 0.0, 0.002, 0.008, 0.016, 0.03, 0.05, 0.1, 0.2))
        d.maybe(0.3, link__loss=d.between(0.0, 0.3), link__jitter_s=d.between(0.0, 0.02))
    elif d.happens(0.5):
        d.maybe(1.0, link__preset=d.one_of(*PRESETS))
    d.maybe(0.1, link__schedule=d.one_of("2 outage; 2.5 base", "1 outage; 2 base"))
    d.maybe(0.1, link__down__delay_s=d.between(0.0, 0.1))


def loop(d):
    d.maybe(0.5, server__contact_stiffness=d.scale(50.0, 20_000.0))
    d.maybe(0.4, server__contact_damping=d.between(0.0, 40.0))
    frame = d.one_of(2, 4, 16, 20)
    d.maybe(0.3, server__period_s=frame / 1000.0, master__rate_drop=frame)
    d.maybe(0.3, server__object_mass=d.scale(0.1, 10.0))
    d.maybe(0.4, master__impedance=d.scale(2.0, 100.0))
    d.maybe(0.1, server__impedance=d.scale(5.0, 80.0))
    d.maybe(0.15, server__coupling=d.one_of("one_step_delay", "one_frame_late", "unwrapped"))
    d.maybe(0.3, device__mass=d.scale(0.05, 1.0), device__damping=d.between(0.0, 3.0))
    d.maybe(0.15, device__friction=d.between(0.0, 0.5))
    d.maybe(0.1, device__encoder_step_m=d.scale(1e-6, 1e-4), device__velocity="euler")
    d.maybe(0.1, master__position__gain=d.between(5.0, 60.0))
    d.maybe(0.2, safety__max_force=d.one_of(3.3, 8.0, 20.0))
    d.maybe(0.15, changes=d.one_of(*CHANGES))


def hand(d, data):
    kind = d.one_of(*OPERATORS)
    given = {"kind": kind}
    if kind == "hand":
        d.maybe(1.0, task__kind=d.one_of("hold", "carry"))
        given |= {"stiffness": d.scale(10.0, 300.0), "damping": d.between(1.0, 25.0)}
        given |= {"squeeze": d.between(0.3, 4.0)}
    elif kind in ("force", "motion"):
        file, unit = (("tue_spring.csv", d.one_of(0.3, -0.3)), ("tue_hand.csv", 0.075))[
            kind == "motion"
        ]
        given = {
            "kind": f"playback_{kind}",
            "file": str(data / file),
            "rate_hz": 2000.0,
            "repeat": True,
        }
        given |= {"scale": unit * d.one_of(0.5, 1.0, 1.5), "columns": "0"}
        given |= {"offset": d.between(-0.01, 0.025)} if kind == "motion" else {}
    elif kind != "none":
        given |= {"force": d.between(0.2, 4.0), "frequency_hz": d.scale(0.3, 12.0)}
    alone = kind in ("constant", "sinusoid") and d.happens(0.5)
    d.maybe(float(alone), operator__kind="none")
    of = "user1.operator." if alone else "operator."
    d.settings |= {f"{of}{name}": value for name, value in given.items()}


def drawn(seed, data):
    """Return the scenario of a seed: the first of its draws that has no conflict."""
    d = Draw(seed)
    while True:
        d.settings, name = {"seed": seed}, d.one_of(*SCENARIOS)
        d.maybe(
            1.0, controller=d.one_of(*["pmwvc"] * 4, "direct", "virtual_coupling", "tdpa", "pspm")
        )
        waves = d.settings["controller"] == "pmwvc"
        if name == "active_wall" and not waves:
            continue
        if waves:
            d.maybe(1.0, channel=d.one_of("strict", "strict", "plain", "zeroing"))
        users = d.one_of(None, None, None, 1, 3) if name in ("carry_16ms", "stiff_24ms") else None
        d.maybe(0.2 * (name != "cube_3d"), dof=d.one_of(2, 3))
        network(d)
        loop(d)
        if name != "playback" and d.happens(0.7):
            hand(d, data)
        d.maybe(0.7, task__grip_s=0.3, task__grip_rise_s=0.5, task__move_s=1.5)
        if waves and name in ("wall", "wall_slow") and d.happens(0.3):
            place = d.one_of(*PLACES)
            d.maybe(1.0, server__coupling="unknown", server__environment=place)
            d.maybe(
                0.5, server__decoding="late", server__compensation=d.one_of("none", "corrected")
            )
        try:
            return parse_scenario(
                read(find(name)), source=name, overrides=d.settings, users=users,
                duration_s=d.one_of(3.0, 3.0),
            )  # fmt: skip
        except PmwvcError:
            continue


def report_of(traces, scenario, found, energies):
    """Return the words of the report."""
    page = render(traces, scenario, found, [], energies)
    page = re.sub(r"<(style|script).*?</\1>", "", page, flags=re.S)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", page)).split())


def page_of(scenario):
    """Return levels and sentences of a page that shows the session, as they followed."""
    now_s = [0.0]
    page, said = SimulatedSession(scenario, clock=lambda: now_s[0]), []
    while now_s[0] < scenario.duration_s:
        now_s[0] += SNAPSHOT_S
        page.poll()
        told = page.news()["text"]
        said.append((told["level"], told["verdict"]))
    page.close()
    return said


def differences(found, terminal, report, said):
    """Return where the outputs do not say the same."""
    lines = [" ".join(line["text"].split()) for line in found["verdict"]]
    wrong = [f"not in the report: {line}" for line in lines if line not in report]
    shown = " ".join(" ".join(terminal).split()).lower()
    wrong += [f"not on the terminal: {line}" for line in lines if line.lower() not in shown]
    if not said:
        return wrong
    passive, (level, last) = found["passivity"]["passive"], said[-1]
    if any("Not passive" in text for _, text in said) != (passive is False):
        wrong.append(f"passive {passive}, and the page ends with: {last}")
    if (found["stable"], level) == (False, "good") or (found["stable"] and "Not stable" in last):
        wrong.append(f"stable {found['stable']}, and the page ends with: {last}")
    return wrong


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drawn_session_says_no_wrong_word(seed, recorded_data, monkeypatch):
    # Sessions that measure what is rendered have no verdict (``test_probes.py``).
    monkeypatch.setattr(probes, "probed", lambda of, user: (Rendering(), "not at all"))
    scenario = drawn(seed, recorded_data)
    traces, twin = stepped(scenario)
    energies = budget(traces, scenario)
    found = summary(traces, scenario, energies)
    exact = not any(
        user.device.encoder_step_m > 0.0 or user.master.deadband.is_on for user in scenario.users
    )
    wrong = wrong_words(own_judgement(scenario, traces, twin), found, exact=exact)
    said = page_of(scenario) if seed % PAGE_EVERY == 0 and not scenario.changes else []
    report = report_of(traces, scenario, found, energies)
    wrong += differences(found, verdict_lines(found), report, said)
    assert not wrong, (scenario.name, found["stability"]["text"], found["passivity"]["text"])
