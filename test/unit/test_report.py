# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report, the last step of a session that writes it, and its drawing of the loop with the
session's own numbers.
"""

import dataclasses
import json
import re
import subprocess
import xml.etree.ElementTree as ET
from html.parser import HTMLParser

import pytest
from support import handmade
from support.command_line import ROOT, here

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.report.loop import blocks, drawing
from pmwvc_analysis.report.report import render
from pmwvc_analysis.session_files import finish
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup.scenarios import load
from pmwvc_core.simulation.session import simulate_one

VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """Checks that elements close in order; keeps the text and what is loaded from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.open, self.words, self.sources, self.ids = [], [], [], set()
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)
        self.sources += [value for name, value in attributes if name in ("src", "href")]
        self.ids |= {value for name, value in attributes if name == "id"}

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("style", "script"):
            self.words.append(data)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.words))


def page(traces, scenario):
    return Page(render(traces, scenario, summary(traces, scenario), []))


def test_the_verdict_comes_first_in_plain_words():
    text = page(handmade.session(), handmade.scenario()).text
    calm = "oscillation beyond the voluntary band is 0.0 mm/s at the end (limit 1 mm/s)."
    verdict = text.index(f"Stable: {calm}")
    assert verdict < text.index("Prediction") < text.index("Figures")
    assert re.search(
        r"user1: passive: least balance at server steps 0 J, tolerance [\d.]+ µJ\.", text
    )


def test_an_unstable_session_gives_the_reason():
    traces = handmade.oscillating(handmade.session(), rms_m_s=0.02, hertz=9.0)
    text = page(traces, handmade.scenario()).text
    assert "Not stable, sustained oscillation: user1's device keeps oscillating with" in text
    assert "Predicted stable, but it was not" in text


def test_events_are_listed_in_order():
    traces = handmade.session()
    traces.events = [
        {"time_s": 2.5, "who": "server", "kind": "ended", "what": "killed by SIGKILL"},
        {"time_s": None, "who": "recorder", "kind": "cut", "what": "session.mcap ends early"},
    ]
    text = page(traces, handmade.scenario()).text
    listed = text[text.index("Events") :]
    assert listed.index("ends early") < listed.index("killed by SIGKILL")
    assert "Interrupted: server killed by SIGKILL at 2.50 s." in text


def test_what_comes_from_files_cannot_become_markup():
    traces = handmade.session()
    traces.events = [{"time_s": 1.0, "who": "<script>x</script>", "kind": "ended", "what": "<b>"}]
    found = render(traces, handmade.scenario(), summary(traces, handmade.scenario()), [])
    assert "<script>x" not in found


@pytest.mark.parametrize("missing", ["server", "a user", "fates", "scenario", "everything"])
def test_parts_may_be_missing(missing):
    traces, scenario = handmade.session(), handmade.scenario()
    if missing in ("server", "everything"):
        traces.server = None
    if missing == "a user":
        del traces.users[1]
    if missing in ("fates", "everything"):
        traces.fates, traces.packets, traces.counts = {}, {}, {}
    if missing == "everything":
        traces.users = []
    if missing in ("scenario", "everything"):
        scenario = None
    text = page(traces, scenario).text
    assert ("passivity not judged" in text.lower()) == (missing in ("server", "everything"))
    assert ("Prediction" in text) == (scenario is not None)


def test_finish_writes_summary_report_and_plots(tmp_path):
    traces, scenario = handmade.session(duration_s=1.6), handmade.scenario(duration_s=1.6)
    record_traces(tmp_path, traces, scenario)
    result = finish(tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text()) == result
    assert result["source"] == "simulated"
    found = Page((tmp_path / "report.html").read_text())
    plots = {path.stem for path in (tmp_path / "plots").glob("*.png")}
    assert plots == {path.stem for path in (tmp_path / "plots").glob("*.svg")}
    assert plots == {"positions", "forces", "energy", "network"}
    assert plots <= found.ids
    assert [source[:22] for source in found.sources] == ["data:image/png;base64,"] * len(plots)
    assert not re.search(r"https?://(?!www\.w3\.org/)", (tmp_path / "report.html").read_text())
    assert "Nothing is missing in the recording." in found.text
    assert "master.impedance 25.0" in found.text


def test_a_report_that_finds_no_room_states_how_to_write_it_elsewhere(tmp_path):
    """A limit of the size of files stands for the full disk."""
    place, other = tmp_path / "session", tmp_path / "other"
    record_traces(place, handmade.session(duration_s=0.8), handmade.scenario(duration_s=0.8))
    # Python compiles its first modules before it ignores the signal of that limit.
    command = f"ulimit -f 0; PYTHONDONTWRITEBYTECODE=1 exec {ROOT / 'pmwvc'} report {place}"
    full = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert full.returncode == 2
    assert f"'pmwvc report {place} --out FOLDER' writes the report elsewhere" in full.stderr
    result = here("report", place, "--out", other, "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout) == json.loads((other / "summary.json").read_text("utf-8"))
    assert (other / "report.html").stat().st_size > 10_000


def texts(svg):
    return [element.text for element in ET.fromstring(svg).iter("text")]


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"controller": "direct"},
        {"controller": "tdpa"},
        {"master__bank__kind": "complementary"},
        {"server__environment": "wall", "users": 1},
    ],
)
def test_the_energies_of_all_blocks_are_those_of_the_budget(settings):
    scenario = handmade.scenario(duration_s=2.0, **settings)
    traces = simulate_one(scenario)
    found = budget(traces, scenario)
    shared, hands, own = 0.0, 0.0, 0.0
    for user in scenario.users:
        of = blocks(scenario, user, found)
        hands += of["hand"].energy_j
        own += sum(
            of[k].energy_j or 0.0 for k in ("device", "port", "filter", "hold", "up", "down")
        )
        shared = sum(of[k].energy_j for k in ("decoder", "contact", "object"))
    assert hands == pytest.approx(own + shared + found.residual_j[-1], abs=1e-12)
    assert abs(hands) > 1e-4


def test_the_drawing_has_every_block_and_its_numbers():
    scenario = handmade.scenario(duration_s=1.0, link__delay_s=0.024, device__mass=0.31)
    found = blocks(scenario, scenario.users[0], budget(simulate_one(scenario), scenario))
    drawn = drawing(found, name="user1", waves=True)
    places = [element.get("x") for element in ET.fromstring(drawn).iter("rect")]
    assert len(places) == len(found) == 10
    shown = texts(drawn)
    for text in ("0.31 kg", "24 ms", "b = 25 N s/m", "1 kHz", "125 Hz", "K = 500 N/m", "u_m"):
        assert text in shown
    assert "u_m" not in texts(drawing(found, name="user1", waves=False))


def test_what_generated_energy_is_marked():
    scenario = handmade.scenario(duration_s=1.0)
    found = blocks(scenario, scenario.users[0], None)
    found["decoder"] = found["decoder"]._replace(energy_j=-2e-3)
    root = ET.fromstring(drawing(found, name="user1", waves=True))
    marked = [
        element.text for element in root.iter("text") if element.get("class") == "loop-alarm"
    ]
    assert marked == ["E = −2 mJ"]


def test_names_cannot_become_markup():
    scenario = handmade.scenario(duration_s=1.0)
    (user, *_) = scenario.users
    user = dataclasses.replace(user, name="<b>&")
    markup = drawing(blocks(scenario, user, None), name=user.name, waves=True)
    assert ET.fromstring(markup).get("aria-label") == "Control loop of <b>&"


def test_on_the_strict_channel_no_filter_and_no_hold_is_drawn():
    texts = ["channel=strict", "master.deadband.kind=weber"]
    scenario = load("carry_16ms", settings_texts=texts)
    found = blocks(scenario, scenario.users[0], None)
    assert (found["filter"].title, found["hold"].title) == ("sender", "playout")
    assert "deadband 10%" in found["filter"].lines
    plain = load("carry_16ms", settings_texts=["channel=plain"])
    assert blocks(plain, plain.users[0], None)["hold"].title == "hold"
