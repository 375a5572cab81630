# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The report, and the last step of a session that writes it."""

import json
import re
import subprocess
from html.parser import HTMLParser

import pytest
from support import handmade
from support.command_line import ROOT, here

from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.report.report import render
from pmwvc_analysis.session_files import finish
from pmwvc_analysis.verdicts.verdicts import summary

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


def test_a_channel_that_gave_out_energy_is_named_with_amount_and_time():
    text = page(handmade.session(gain=1.2), handmade.scenario()).text
    assert re.search(
        r"user1: NOT passive: link from the device to the server, "
        r"least balance at server steps -[\d.]+ mJ at 3\.99 s \([\d.]+ % of [\d.]+ mJ moved\), "
        r"tolerance [\d.]+ µJ\.",
        text,
    )


def test_an_unstable_session_gives_the_reason():
    traces = handmade.oscillating(handmade.session(), rms_m_s=0.02, hertz=9.0)
    text = page(traces, handmade.scenario()).text
    assert "Not stable, sustained oscillation: user1's device keeps oscillating with" in text
    assert "Predicted stable, but it was not" in text


def test_events_are_listed_in_order():
    traces = handmade.session()
    traces.events = [
        {"time_s": 2.5, "who": "server", "what": "killed by SIGKILL"},
        {"time_s": None, "who": "recorder", "what": "session.mcap ends early"},
    ]
    text = page(traces, handmade.scenario()).text
    listed = text[text.index("Events") :]
    assert listed.index("ends early") < listed.index("killed by SIGKILL")
    assert "Interrupted: server killed by SIGKILL at 2.50 s." in text


def test_what_comes_from_files_cannot_become_markup():
    traces = handmade.session()
    traces.events = [{"time_s": 1.0, "who": "<script>x</script>", "what": "<b>"}]
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
    assert plots == {"positions", "forces", "energy", "budget", "network"}
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


@pytest.mark.parametrize(("more", "measured"), [({"controller": "tdpa"}, True), ({}, False)])
def test_where_no_model_tells_what_is_rendered_simulated_sessions_measure_it(more, measured):
    scenario = handmade.scenario(**more)
    text = page(handmade.session(), scenario).text
    assert ("Measured in simulated sessions: stiffness" in text) == measured
    assert ("the link acts like a spring" in text) != measured
